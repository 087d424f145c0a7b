// Keys in files, and who gets through the door with them.
#include "common/zap.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/wire.h"

namespace evograsp {
namespace {

class Keys : public ::testing::Test {
 protected:
  Keys() {
    std::string name = (std::filesystem::temp_directory_path() / "evograsp-keys-XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~Keys() override { std::filesystem::remove_all(dir_); }
  std::filesystem::path dir_;
};

TEST_F(Keys, AreWrittenForTheirOwnerAloneAndReadBack) {
  const auto made = generate_keys(dir_ / "a.key", "");
  ASSERT_TRUE(made) << made.error().message;
  struct stat info {};
  ASSERT_EQ(stat((dir_ / "a.key").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600U);
  const auto read = load_keys(dir_ / "a.key");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->public_key, made->public_key);
  EXPECT_EQ(read->secret_key, made->secret_key);
  EXPECT_FALSE(generate_keys(dir_ / "a.key", "")) << "a key was overwritten";
}

TEST_F(Keys, ReadableByOthersAreRefused) {
  ASSERT_TRUE(generate_keys(dir_ / "a.key", ""));
  chmod((dir_ / "a.key").c_str(), 0644);
  const auto read = load_keys(dir_ / "a.key");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("chmod 600"), std::string::npos);
}

TEST_F(Keys, OfOtherCharactersOrAnotherLengthAreRefusedByTheirLine) {
  const std::string good = "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID";
  std::string with_nul = good;
  with_nul[35] = '\0';  // the 35 before it would pass for a shorter key
  for (const std::string& bad : {with_nul, good.substr(1), good + "0", std::string(40, '~')}) {
    std::ofstream(dir_ / "a.key") << "secret-key = " << good << "\npublic-key = " << bad << "\n";
    chmod((dir_ / "a.key").c_str(), 0600);
    const auto read = load_keys(dir_ / "a.key");
    ASSERT_FALSE(read) << bad;
    EXPECT_NE(read.error().message.find("a.key:2"), std::string::npos) << read.error().message;
    std::ofstream(dir_ / "list") << good << "\n" << bad << " node 2\n";
    EXPECT_FALSE(load_allow_list(dir_ / "list")) << bad;
  }
}

TEST_F(Keys, AnAllowListNamesItsBadLine) {
  const auto keys = generate_keys(dir_ / "a.key", "");
  std::ofstream(dir_ / "list") << "# workers\n" << keys->public_key << " node 1\nnonsense\n";
  const auto list = load_allow_list(dir_ / "list");
  ASSERT_FALSE(list);
  EXPECT_NE(list.error().message.find("list:3"), std::string::npos) << list.error().message;
  std::ofstream(dir_ / "list") << "# workers\n" << keys->public_key << " node 1\n";
  EXPECT_EQ(load_allow_list(dir_ / "list")->size(), 1U);
}

TEST_F(Keys, OnlyThoseOnTheListGetThrough) {
  const CurveKeys master = *generate_keys(dir_ / "master", "");
  const CurveKeys friendly = *generate_keys(dir_ / "friend", master.public_key);
  const CurveKeys stranger = *generate_keys(dir_ / "stranger", master.public_key);
  zmq::context_t context(1);
  const auto gatekeeper = std::move(*Gatekeeper::create(context, std::set<std::string>{friendly.public_key}));
  SocketOptions options;
  options.curve = master;
  zmq::socket_t router = std::move(*make_router(context, options));
  const std::string endpoint = *bind(router, "tcp://127.0.0.1:*");
  const auto gets_through = [&](const SocketOptions& client_options) {
    zmq::socket_t client = std::move(*make_dealer(context, endpoint, client_options));
    send(client, {}, to_frame("knock"));
    zmq::pollitem_t item{router.handle(), 0, ZMQ_POLLIN, 0};
    zmq::poll(&item, 1, std::chrono::milliseconds(client_options.curve ? 1000 : 300));
    if (item.revents == 0) return false;
    zmq::message_t peer, text;
    EXPECT_TRUE(router.recv(peer));
    EXPECT_TRUE(router.recv(text));
    return text.to_string() == "knock";
  };
  SocketOptions client;
  client.curve = friendly;
  EXPECT_TRUE(gets_through(client));
  client.curve = stranger;
  EXPECT_FALSE(gets_through(client)) << "knowing the server's public key is not enough";
  EXPECT_FALSE(gets_through(SocketOptions())) << "plain text";
  EXPECT_GE(gatekeeper->refused(), 1U);
}

TEST(Exposure, NeedsKeysOrAnExplicitWord) {
  EXPECT_TRUE(check_exposure("tcp://127.0.0.1:5555", false, false));
  EXPECT_TRUE(check_exposure("inproc://evograsp", false, false));
  EXPECT_FALSE(check_exposure("tcp://*:5555", false, false));
  EXPECT_FALSE(check_exposure("tcp://0.0.0.0:5555", false, false));
  EXPECT_FALSE(check_exposure("tcp://1270.example.org:5555", false, false));
  EXPECT_TRUE(check_exposure("tcp://*:5555", true, false));
  EXPECT_TRUE(check_exposure("tcp://*:5555", false, true));
}

}  // namespace
}  // namespace evograsp
