// The connection to a server, over its HTTP API.
#include <httplib.h>

#include <atomic>

#include "cli/request_guard.h"
#include "cli/server_answers.h"
#include "server/api.h"

namespace evograsp::cli {
namespace {

constexpr int kSecondsToConnect = 5;
constexpr int kSecondsToAnswer = 15;               // a checkpoint waits for the disk
constexpr std::chrono::seconds kSecondsInAll{30};  // of one answer, however it drips
constexpr std::size_t kLargestAnswer = 64 << 20;   // bytes, unpacked

const char* in_words(httplib::Error error) {
  switch (error) {
    case httplib::Error::Connection:
      return "no connection";
    case httplib::Error::ConnectionTimeout:
    case httplib::Error::Read:
      return "it took too long or hung up";
    default:
      return "the request failed";
  }
}

// Not thread-safe.
class Connection {
 public:
  Connection(std::string url, const std::string& token) : url_(std::move(url)), client_(url_) {
    client_.set_connection_timeout(kSecondsToConnect);
    client_.set_read_timeout(kSecondsToAnswer);
    client_.set_socket_options([this](socket_t socket) { socket_ = socket; });
    if (!token.empty()) client_.set_bearer_token_auth(token);
  }
  bool valid() const { return client_.is_valid(); }

  Result<HttpAnswer> ask(const char* method, const std::string& path, const std::string& body) {
    std::string received;
    httplib::Request request;
    request.method = method;
    request.path = path;
    if (!body.empty()) {
      request.body = body;
      request.set_header("Content-Type", "application/json");
    }
    request.content_receiver = [&received](const char* data, std::size_t size, std::uint64_t, std::uint64_t) {
      if (size > kLargestAnswer - received.size()) return false;
      received.append(data, size);
      return true;
    };
    const RequestGuard guard([this] { client_.stop(); }, socket_, kSecondsInAll, kLargestAnswer);
    const httplib::Result answer = client_.send(request);
    if (guard.stopped() || answer.error() == httplib::Error::Canceled)
      return fail(ErrorCode::kUnavailable,
                  url_ + ": its answer has no end: more than " + std::to_string(kLargestAnswer >> 20) +
                      " MiB, or longer than " + std::to_string(kSecondsInAll.count()) + " s");
    if (!answer)
      return fail(ErrorCode::kUnavailable,
                  url_ + ": no server answers (" + in_words(answer.error()) +
                      "); start one with evograsp-server, name another with --server URL, or look into a run "
                      "folder with --run DIR");
    return HttpAnswer{answer->status, std::move(received), answer->get_header_value("X-Evograsp-Champion")};
  }

 private:
  const std::string url_;
  httplib::Client client_;
  std::atomic<int> socket_{-1};  // of the client's last connection
};

}  // namespace

Result<std::unique_ptr<Source>> open_server(const std::string& url) {
  std::string address = url.find("://") == std::string::npos ? "http://" + url : url;
  while (address.ends_with('/')) address.pop_back();
  if (!address.starts_with("http://") && !address.starts_with("https://"))
    return fail(ErrorCode::kUsage, "--server: '" + url + "' is no address like http://127.0.0.1:8080");
  const auto token = server::load_token("");
  if (!token) return tl::unexpected(token.error());
  try {
    const auto connection = std::make_shared<Connection>(address, *token);
    if (connection->valid())
      return server_source(
          address, [connection](const char* method, const std::string& path, const std::string& body) {
            return connection->ask(method, path, body);
          });
  } catch (const std::exception&) {
    // The library throws for a port that is no number.
  }
  return fail(ErrorCode::kUsage, "--server: '" + url + "' is no address like http://127.0.0.1:8080");
}

}  // namespace evograsp::cli
