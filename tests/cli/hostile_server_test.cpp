// HTTP servers that are none, or mean ill, before the commands that ask them.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <thread>

#include "cli/json_input.h"
#include "cli/program.h"
#include "cli/request_guard.h"

namespace evograsp::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

void say(int to, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::send(to, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (n <= 0) return;
    done += static_cast<std::size_t>(n);
  }
}

// Hands each connection, its request read, to `answer` with the path that was asked for.
class Evil {
 public:
  using Answer = std::function<void(int connection, const std::string& path)>;
  explicit Evil(Answer answer) : answer_(std::move(answer)), door_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(door_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::getsockname(door_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    EXPECT_EQ(::listen(door_, 16), 0);
    url_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] { serve(); });
  }
  ~Evil() {
    ::shutdown(door_, SHUT_RDWR);
    // Who is not read any more would wait for the kernel's timers to learn that nobody is there.
    if (connection_ >= 0) ::shutdown(connection_, SHUT_RDWR);
    thread_.join();
    ::close(door_);
  }
  const std::string& url() const { return url_; }

 private:
  void serve() {
    for (int c = 0; (c = ::accept(door_, nullptr, nullptr)) >= 0;) {
      connection_ = c;
      std::string request(8192, '\0');
      const ssize_t n = ::recv(c, request.data(), request.size(), 0);
      std::istringstream words(request.substr(0, static_cast<std::size_t>(std::max<ssize_t>(n, 0))));
      std::string method, path;
      words >> method >> path;
      if (!path.empty()) answer_(c, path);
      connection_ = -1;
      ::close(c);
    }
  }
  const Answer answer_;
  const int door_;
  std::atomic<int> connection_{-1};
  std::string url_;
  std::thread thread_;
};

Evil::Answer document(const std::string& body, const std::string& status = "200 OK") {
  return [=](int to, const std::string&) {
    say(to, "HTTP/1.1 " + status + "\r\nContent-Type: application/json\r\nContent-Length: " +
                std::to_string(body.size()) + "\r\nConnection: close\r\n\r\n" + body);
  };
}

// Answers /run with one document and everything else with another.
Evil::Answer run_and(const std::string& run, const std::string& rest) {
  return [=](int to, const std::string& path) {
    document(path.find("/run") != std::string::npos ? run : rest)(to, path);
  };
}

struct Said {
  int code = 0;
  std::string out, err;
};

Said evograsp(std::vector<std::string> words) {
  words.insert(words.begin(), "evograsp");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Said said;
  said.code = run(static_cast<int>(argv.size()), argv.data());
  said.out = ::testing::internal::GetCapturedStdout();
  said.err = ::testing::internal::GetCapturedStderr();
  return said;
}

TEST(HostileServer, MembersOfOtherTypesAreAsGoodAsNone) {
  const std::string odd =
      R"({"name": 5, "state": "running", "committed": 18446744073709551615, "generations": "x", "phase": [],
          "champion": {"chosen": 5, "available": "x"}, "fitness": 7, "workers": null, "species": [1],
          "evaluations": {"total": -1}, "trials_per_second": 1e300, "seconds": 1e300, "seconds_left": 1e300})";
  const std::string bare = R"({"state": "finished", "champion": null})";
  const std::string rows = R"({"generations": [1, "x", null, []], "workers": 5, "events": {"a": 1}})";
  for (const std::string& run : {odd, bare, std::string("{}")}) {
    const Evil server(run_and(run, rows));
    for (const char* command :
         {"status", "watch", "workers", "generations", "species", "events", "history"}) {
      std::vector<std::string> words{command, "--server", server.url()};
      if (std::string(command) == "watch") words.insert(words.end(), {"--count", "1"});
      EXPECT_EQ(evograsp(words).code, 0) << command << " on " << run;
    }
  }
}

TEST(HostileServer, ErrorsOfOtherTypesAreNoServersOfOurs) {
  for (const char* body : {R"({"error": {"message": 5}})", R"({"error": {"message": {"a": 1}}})",
                           R"({"error": []})", R"([1])", "\xff\xfe", ""}) {
    const Evil server(document(body, "500 Bad"));
    const Said said = evograsp({"status", "--server", server.url()});
    EXPECT_EQ(said.code, 6) << body;
    EXPECT_THAT(said.err, HasSubstr("no evograsp server")) << body;
  }
}

TEST(HostileServer, DocumentsWithoutABottomAreRefused) {
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "{\"a\":";
  deep += "1" + std::string(100000, '}');
  const Evil server(document(deep));
  EXPECT_EQ(evograsp({"status", "--json", "--server", server.url()}).code, 6);
  EXPECT_TRUE(parse_json("[[1]]").is_array());
  EXPECT_TRUE(parse_json(R"({"a": 1, "a": 2})").is_object());
  EXPECT_TRUE(parse_json(R"({"a": {"b": 1}, "b": 1})", Duplicates::kRefuse).is_object());
  EXPECT_TRUE(parse_json(R"({"a": 1, "a": 2})", Duplicates::kRefuse).is_discarded());
  EXPECT_TRUE(parse_json(std::string(kDeepestJson, '[') + std::string(kDeepestJson, ']')).is_array());
  EXPECT_TRUE(
      parse_json(std::string(kDeepestJson + 1, '[') + std::string(kDeepestJson + 1, ']')).is_discarded());
}

TEST(HostileServer, PagesThatDoNotGoOnEnd) {
  const Evil server(
      run_and(R"({"state": "running", "committed": 5})", R"({"generations": [{}], "next": 1})"));
  for (const char* command : {"history", "watch", "generations"}) {
    const Said said = evograsp({command, "--server", server.url()});
    EXPECT_EQ(said.code, 6) << command;
    EXPECT_THAT(said.err, HasSubstr("do not go on")) << command;
  }
}

TEST(HostileServer, AChampionThatIsNoneReplacesNoFile) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("evograsp_kept_" + std::to_string(::getpid()))).string();
  std::ofstream(file) << "the old one";
  for (const std::string& body : {std::string(), std::string("\x08\x01"), std::string("garbage")}) {
    const Evil server(document(body));
    EXPECT_EQ(evograsp({"champion", "--server", server.url(), "--out", file}).code, 3) << body;
    std::stringstream kept;
    kept << std::ifstream(file).rdbuf();
    EXPECT_EQ(kept.str(), "the old one");
  }
  std::filesystem::remove(file);
}

TEST(HostileServer, NamesAndReasonsCannotSteerTheTerminal) {
  const std::string red = "\\u001b[31mred\\u009b2J";
  const std::string run = R"({"name": ")" + red + R"(", "state": ")" + red + R"(", "phase": ")" + red +
                          R"(", "folder": ")" + red + R"(", "error": ")" + red + R"("})";
  const Evil server(run_and(run, "{}"));
  for (const char* command : {"status", "watch"}) {
    const Said said = evograsp({command, "--server", server.url()});
    EXPECT_THAT(said.out, HasSubstr("red")) << command;
    EXPECT_THAT(said.out, Not(HasSubstr("\x1b"))) << command;
    EXPECT_THAT(said.out, Not(HasSubstr("\xc2\x9b"))) << command;
  }
  const Said json = evograsp({"status", "--json", "--server", server.url()});
  EXPECT_THAT(json.out, HasSubstr("\\u001b[31mred\\u009b2J"));
  EXPECT_THAT(json.out, Not(HasSubstr("\xc2\x9b")));
  const Evil refuses(document(R"({"error": {"message": "\u001b[31mred"}})", "404 Not Found"));
  const Said said = evograsp({"status", "--server", refuses.url()});
  EXPECT_EQ(said.code, 4);
  EXPECT_THAT(said.err, HasSubstr("red"));
  EXPECT_THAT(said.err, Not(HasSubstr("\x1b")));
}

TEST(HostileServer, AnswersWithoutEndAreCutOff) {
  const Evil body([](int to, const std::string&) {
    say(to, "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n\r\n");
    for (int i = 0; i < 200; ++i) say(to, std::string(1 << 20, 'a'));
  });
  const Evil headers([](int to, const std::string&) {
    say(to, "HTTP/1.1 200 OK\r\n");
    std::string some;
    for (int i = 0; i < 1000; ++i) some += "X: " + std::string(1000, 'a') + "\r\n";
    for (int i = 0; i < 200; ++i) say(to, some);
  });
  for (const Evil* server : {&body, &headers}) {
    const Said said = evograsp({"status", "--server", server->url()});
    EXPECT_EQ(said.code, 6);
    EXPECT_THAT(said.err, HasSubstr("has no end"));
  }
}

TEST(HostileServer, AByteNowAndThenIsNoProgress) {
  std::atomic<int> stops{0};
  const std::atomic<int> no_socket{-1};
  {
    const RequestGuard guard([&stops] { ++stops; }, no_socket, std::chrono::seconds(0), 1);
    for (int i = 0; i < 500 && stops == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_TRUE(guard.stopped());
  }
  EXPECT_GT(stops, 0) << "nobody ended the request";
  stops = 0;
  {
    const RequestGuard guard([&stops] { ++stops; }, no_socket, std::chrono::seconds(600), 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_FALSE(guard.stopped());
  }
  EXPECT_EQ(stops, 0);
}

}  // namespace
}  // namespace evograsp::cli
