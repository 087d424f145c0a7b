// What strangers can cause a million of stays bounded, in memory and in the file, though no generation is
// committed meanwhile.
#include <algorithm>

#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

WorkerRecord worker_of(const std::string& identity, const std::string& state, std::uint64_t trials) {
  WorkerRecord worker;
  worker.identity = identity;
  worker.state = state;
  worker.trials = trials;
  worker.last_seen = 1;
  return worker;
}

// journal_seconds: how long the store's thread may leave things queued.
std::unique_ptr<Store> store_in(const RunFolder& folder, double journal_seconds) {
  NewRun run = new_run();
  run.info.config.mutable_store()->set_journal_seconds(journal_seconds);
  return std::move(*Store::create(folder.path(), std::move(run)));
}

TEST(StoreBounds, TheNewestTenThousandEventsAreKeptWithoutAnyGeneration) {
  RunFolder folder;
  const auto store = store_in(folder, 0.01);
  for (int batch = 0; batch < 6; ++batch) {
    for (int i = 0; i < 2000; ++i)
      store->note({0, 1, Severity::kInfo, "knock", std::to_string(batch * 2000 + i)});
    ASSERT_TRUE(store->flush());
  }
  const auto reader = *StoreReader::open(folder.path());
  const auto oldest = reader->events(1, 1), newest = reader->events(0, 1);
  ASSERT_TRUE(oldest && oldest->size() == 1);
  ASSERT_TRUE(newest && newest->size() == 1);
  EXPECT_EQ(newest->back().text, "11999");
  EXPECT_EQ(oldest->front().text, "2000");
}

TEST(StoreBounds, AFloodOfEventsDoesNotFillTheQueue) {
  RunFolder folder;
  const auto store = store_in(folder, 3600);
  std::uint64_t most = 0;
  for (int i = 0; i < 200000; ++i) {
    store->note({0, 1, Severity::kInfo, "knock", std::to_string(i)});
    if (i % 100 == 0) most = std::max(most, store->figures().queued_bytes);
  }
  EXPECT_LE(most, 10100u * 64u) << "more than 10,000 small rows wait";
  ASSERT_TRUE(store->flush());
}

TEST(StoreBounds, OfOneWorkerOnlyTheLastWordIsQueued) {
  RunFolder folder;
  const auto store = store_in(folder, 0.01);
  for (std::uint64_t i = 0; i < 100000; ++i) {
    store->saw_worker(worker_of("same", i % 2 == 0 ? "active" : "gone", i));
    ASSERT_LE(store->figures().queued_bytes, 1000u);
  }
  ASSERT_TRUE(store->flush());
  const auto workers = (*StoreReader::open(folder.path()))->workers();
  ASSERT_TRUE(workers && workers->size() == 1);
  EXPECT_EQ(workers->front().trials, 99999u);
  EXPECT_EQ(workers->front().state, "gone");
}

TEST(StoreBounds, TenThousandWorkersAreKeptThoseThatAreHereOrDidSomethingFirst) {
  RunFolder folder;
  const auto store = store_in(folder, 0.01);
  store->saw_worker(worker_of("here", "active", 0));
  store->saw_worker(worker_of("worked", "gone", 5));
  for (int i = 0; i < 12000; ++i) {
    WorkerRecord stranger = worker_of("stranger-" + std::to_string(i), "gone", 0);
    stranger.last_seen = 2 + i;
    store->saw_worker(std::move(stranger));
    if (i % 5000 == 4999) {
      ASSERT_TRUE(store->flush());
    }
  }
  ASSERT_TRUE(store->flush());
  const auto workers = (*StoreReader::open(folder.path()))->workers();
  ASSERT_TRUE(workers);
  EXPECT_EQ(workers->size(), 10000u);
  const auto known = [&](const std::string& identity) {
    return std::any_of(workers->begin(), workers->end(),
                       [&](const auto& w) { return w.identity == identity; });
  };
  EXPECT_TRUE(known("here"));
  EXPECT_TRUE(known("worked"));
  EXPECT_TRUE(known("stranger-11999"));
  EXPECT_FALSE(known("stranger-0"));
}

}  // namespace
}  // namespace evograsp::server
