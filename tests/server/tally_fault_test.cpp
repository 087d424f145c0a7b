// That the soak would notice: evaluations that count twice, vanish or were never counted.
#include "tests/server/store_fixture.h"
#include "tests/soak/soak_journal.h"

namespace evograsp::soak {
namespace {

using server::evaluation_of;
using server::new_run;
using server::RunFolder;
using server::Store;

struct TallyTest : ::testing::Test {
  std::unique_ptr<Store> begin() {
    auto store = *Store::create(folder_.path(), new_run());
    store->journal(evaluation_of(0, 1));
    EXPECT_TRUE(store->flush());
    EXPECT_TRUE(Tally::begin(folder_.path())) << "beside a living writer";
    return store;
  }
  std::string verdict() const { return Tally::verdict(folder_.path()); }
  RunFolder folder_;
};

TEST_F(TallyTest, OnceIsRight) {
  const auto store = begin();
  store->journal(evaluation_of(0, 2));
  ASSERT_TRUE(store->flush());
  EXPECT_EQ(verdict(), "");
  EXPECT_EQ(Tally::accepted(folder_.path()), 2U);
  EXPECT_EQ(read_journal(folder_.path(), 1)->size(), 2U);
}

// The journal itself keeps one row a genome: the last.
TEST_F(TallyTest, OneThatComesTwiceIsNoticedThoughTheJournalHoldsItOnce) {
  const auto store = begin();
  store->journal(evaluation_of(0, 1));
  ASSERT_TRUE(store->flush());
  EXPECT_EQ(read_journal(folder_.path(), 1)->size(), 1U);
  EXPECT_EQ(verdict(), "genome 1 of generation 0 came 2 times, went 0 times and is here");
}

TEST_F(TallyTest, OneThatComesAgainInAnotherLifeOfTheMasterIsNoticed) {
  begin().reset();
  const auto resumed = Store::resume(folder_.path());
  ASSERT_TRUE(resumed) << message(resumed);
  resumed->store->journal(evaluation_of(0, 1));
  ASSERT_TRUE(resumed->store->flush());
  EXPECT_NE(verdict(), "");
}

TEST_F(TallyTest, TakenBackAndDoneAgainCountsOnce) {
  const auto store = begin();
  store->forget_evaluations(0, "", {1});
  ASSERT_TRUE(store->flush());
  EXPECT_EQ(verdict(), "");
  store->journal(evaluation_of(0, 1));
  ASSERT_TRUE(store->flush());
  EXPECT_EQ(verdict(), "");
}

TEST_F(TallyTest, OneThatNobodyCountedIsNoticed) {
  const auto store = begin();
  auto database = *server::Database::open(folder_.file(), server::Database::Mode::kReadWrite);
  ASSERT_TRUE(database->exec("DELETE FROM tally"));
  EXPECT_EQ(verdict(), "1 evaluations were never counted");
}

TEST_F(TallyTest, ADamagedRowMakesItsGenerationUnreadable) {
  auto store = begin();
  store->journal(evaluation_of(1, 1));
  store.reset();
  auto database = *server::Database::open(folder_.file(), server::Database::Mode::kReadWrite);
  ASSERT_TRUE(database->exec("UPDATE evaluations SET measurements = x'00' WHERE generation = 1"));
  EXPECT_FALSE(read_journal(folder_.path(), 2));
  EXPECT_EQ(read_journal(folder_.path(), 2, true)->size(), 1U);
}

}  // namespace
}  // namespace evograsp::soak
