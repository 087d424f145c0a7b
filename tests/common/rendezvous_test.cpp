#include "common/rendezvous.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace evograsp {
namespace {

namespace fs = std::filesystem;

class RendezvousTest : public ::testing::Test {
 protected:
  RendezvousTest() {
    std::string name = (fs::temp_directory_path() / "evograsp-test-XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~RendezvousTest() override { fs::remove_all(dir_); }

  Result<Rendezvous> read_text(const std::string& text) {
    std::ofstream(dir_ / "where") << text;
    return read_rendezvous(dir_ / "where");
  }
  fs::path dir_;
};

TEST(Advertised, NamesTheHostWhereTheAddressStandsForAll) {
  EXPECT_EQ(advertised("tcp://0.0.0.0:40213", "node17"), "tcp://node17:40213");
  EXPECT_EQ(advertised("tcp://[::]:40213", "node17"), "tcp://node17:40213");
  EXPECT_EQ(advertised("tcp://127.0.0.1:5555", "node17"), "tcp://127.0.0.1:5555");
  EXPECT_EQ(advertised("tcp://[fe80::1]:5555", "node17"), "tcp://[fe80::1]:5555");
  EXPECT_EQ(advertised("inproc://evograsp", "node17"), "inproc://evograsp");
  EXPECT_EQ(advertised_http("0.0.0.0:0", 8080, "node17"), "http://node17:8080");
  EXPECT_EQ(advertised_http("127.0.0.1:0", 40871, "node17"), "http://127.0.0.1:40871");
  EXPECT_EQ(advertised_http("", 0, "node17"), "");
}

TEST_F(RendezvousTest, SaysWhatWasWritten) {
  const Rendezvous where{"tcp://node17:40213", "http://node17:40871"};
  ASSERT_TRUE(write_rendezvous(dir_ / "where", where));
  const auto read = read_rendezvous(dir_ / "where");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->connect, where.connect);
  EXPECT_EQ(read->http, where.http);
  EXPECT_EQ(std::distance(fs::directory_iterator(dir_), {}), 1) << "something else was left in the folder";
}

TEST_F(RendezvousTest, IsReplacedAsAWholeAndTakenAwayByItsWriterAlone) {
  const Rendezvous old{"tcp://node1:1"}, successor{"tcp://node2:2"};
  ASSERT_TRUE(write_rendezvous(dir_ / "where", old));
  ASSERT_TRUE(write_rendezvous(dir_ / "where", successor));
  remove_rendezvous(dir_ / "where", old);
  ASSERT_TRUE(read_rendezvous(dir_ / "where"));
  EXPECT_EQ(read_rendezvous(dir_ / "where")->connect, successor.connect);
  remove_rendezvous(dir_ / "where", successor);
  EXPECT_EQ(read_rendezvous(dir_ / "where").error().code, ErrorCode::kNotFound);
}

TEST_F(RendezvousTest, SaysThatTheRunIsOverUnlessASuccessorIsThere) {
  const Rendezvous old{"tcp://node1:1", "http://node1:2"}, successor{"tcp://node2:2"};
  ASSERT_TRUE(write_rendezvous(dir_ / "where", old));
  ASSERT_TRUE(end_rendezvous(dir_ / "where", old, "the run is finished"));
  const auto over = read_rendezvous(dir_ / "where");
  ASSERT_TRUE(over) << over.error().message;
  EXPECT_EQ(over->over, "the run is finished");
  EXPECT_EQ(over->connect + over->http, "");
  ASSERT_TRUE(write_rendezvous(dir_ / "where", successor));
  ASSERT_TRUE(end_rendezvous(dir_ / "where", old, "the run is finished"));
  EXPECT_EQ(read_rendezvous(dir_ / "where")->connect, successor.connect);
}

TEST_F(RendezvousTest, RefusesWhatIsNone) {
  for (const char* text :
       {"", "\n", "connect\n", "connect = \n", "connect = a b\n", "http = x\n", "tcp://a:1\n",
        "connect = tcp://a:1\nport = 2\n", "over = \n", "connect = node17\n", "connect = tcp://\n",
        "connect = tcp://a:1\x1b[2J\n", "over = \xc2\x9b 2J\n"})
    EXPECT_EQ(read_text(text).error().code, ErrorCode::kInvalid) << "'" << text << "'";
  EXPECT_EQ(read_text(std::string(100000, 'x')).error().code, ErrorCode::kInvalid);
  EXPECT_TRUE(read_text("# of job 7\n\nconnect = tcp://a:1\n"));
  EXPECT_EQ(read_text("connect =\ttcp://a:1 \t\r\n")->connect, "tcp://a:1");
}

TEST_F(RendezvousTest, SaysWhyItCannotBeWritten) {
  const Status status = write_rendezvous(dir_ / "none" / "where", {"tcp://a:1"});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
  EXPECT_NE(status.error().message.find("No such file"), std::string::npos) << status.error().message;
}

}  // namespace
}  // namespace evograsp
