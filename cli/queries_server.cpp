// A server as a source of answers, over its HTTP API.
#include <httplib.h>

#include <atomic>

#include "cli/json_input.h"
#include "cli/queries.h"
#include "cli/request_guard.h"
#include "server/api.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;

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

class ServerSource final : public Source {
 public:
  ServerSource(std::string url, std::string token) : url_(std::move(url)), client_(url_) {
    client_.set_connection_timeout(kSecondsToConnect);
    client_.set_read_timeout(kSecondsToAnswer);
    client_.set_socket_options([this](socket_t socket) { socket_ = socket; });
    if (!token.empty()) client_.set_bearer_token_auth(token);
  }
  bool valid() const { return client_.is_valid(); }

  Result<json> run() override { return document("/api/v1/run"); }
  Result<json> workers() override { return document("/api/v1/workers"); }
  Result<json> species(std::optional<std::uint32_t> generation) override {
    return document("/api/v1/species" + (generation ? "?generation=" + std::to_string(*generation) : ""));
  }
  Result<json> generations(std::uint32_t from, std::uint32_t limit) override {
    return document("/api/v1/generations?from=" + std::to_string(from) + "&limit=" + std::to_string(limit));
  }
  Result<json> events(std::int64_t since, std::uint32_t limit) override {
    return document("/api/v1/events?since=" + std::to_string(since) + "&limit=" + std::to_string(limit));
  }

  Result<Champion> champion() override {
    const auto answer = ask("GET", "/api/v1/champion?format=pb");
    if (!answer) return tl::unexpected(answer.error());
    return Champion{answer->body, answer->get_header_value("X-Evograsp-Champion") == "chosen"};
  }

  Result<json> archive() override { return document("/api/v1/archive"); }
  Result<Champion> elite(std::uint32_t x, std::uint32_t y) override {
    const auto answer =
        ask("GET", "/api/v1/archive/champion?x=" + std::to_string(x) + "&y=" + std::to_string(y));
    if (!answer) return tl::unexpected(answer.error());
    return Champion{answer->body, false};
  }

  Status steer(const std::string& verb) override {
    const auto answer = ask("POST", "/api/v1/" + verb);
    if (!answer) return tl::unexpected(answer.error());
    return {};
  }

  Result<json> log_level(const std::optional<std::string>& wanted) override {
    if (!wanted) return document("/api/v1/log-level");
    return parsed(ask("PUT", "/api/v1/log-level", json{{"level", *wanted}}));
  }

  Result<std::uint32_t> drain(const std::string& node, bool drained) override {
    const auto answer = parsed(
        ask("POST", drained ? "/api/v1/workers/drain" : "/api/v1/workers/undrain", json{{"node", node}}));
    if (!answer) return tl::unexpected(answer.error());
    if (!part_in(*answer, "workers").is_number_unsigned()) return not_ours();
    return static_cast<std::uint32_t>(count_in(*answer, "workers"));
  }

  std::string name() const override { return url_; }

 private:
  Result<json> document(const std::string& path) { return parsed(ask("GET", path)); }

  // A status below 300, or an error in our own terms.
  Result<httplib::Response> ask(const char* method, const std::string& path, const json& body = nullptr) {
    std::string received;
    httplib::Request request;
    request.method = method;
    request.path = path;
    if (!body.is_null()) {
      request.body = body.dump(-1, ' ', false, json::error_handler_t::replace);
      request.set_header("Content-Type", "application/json");
    }
    request.content_receiver = [&received](const char* data, std::size_t size, std::uint64_t, std::uint64_t) {
      if (size > kLargestAnswer - received.size()) return false;
      received.append(data, size);
      return true;
    };
    const RequestGuard guard([this] { client_.stop(); }, socket_, kSecondsInAll, kLargestAnswer);
    httplib::Result answer = client_.send(request);
    if (guard.stopped() || answer.error() == httplib::Error::Canceled)
      return fail(ErrorCode::kUnavailable,
                  url_ + ": its answer has no end: more than " + std::to_string(kLargestAnswer >> 20) +
                      " MiB, or longer than " + std::to_string(kSecondsInAll.count()) + " s");
    if (answer) answer->body = std::move(received);
    return checked(std::move(answer));
  }

  Result<json> parsed(const Result<httplib::Response>& answer) const {
    if (!answer) return tl::unexpected(answer.error());
    json document = parse_json(answer->body);
    if (!document.is_object()) return not_ours();
    return document;
  }

  // What an answer comes to in our own terms.
  Result<httplib::Response> checked(httplib::Result answer) const {
    if (!answer)
      return fail(ErrorCode::kUnavailable,
                  url_ + ": no server answers (" + in_words(answer.error()) +
                      "); start one with evograsp-server, name another with --server URL, or look into a run "
                      "folder with --run DIR");
    if (answer->status < 300) return *answer;
    const json body = parse_json(answer->body);
    if (!part_in(part_in(body, "error"), "message").is_string()) return not_ours();
    const std::string message = text_in(part_in(body, "error"), "message");
    switch (answer->status) {
      case 401:
        return fail(ErrorCode::kUsage,
                    url_ + ": " + message + "; put it into a file and set EVOGRASP_TOKEN_FILE to its name");
      case 404:
        return fail(ErrorCode::kNotFound, url_ + ": " + message);
      case 503:
        return fail(ErrorCode::kUnavailable, url_ + ": " + message);
      default:
        return fail(answer->status < 500 ? ErrorCode::kInvalid : ErrorCode::kIo, url_ + ": " + message);
    }
  }

  tl::unexpected<Error> not_ours() const {
    return fail(
        ErrorCode::kUnavailable,
        url_ + ": something answers, but it is no evograsp server; check --server or $EVOGRASP_SERVER");
  }

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
    auto source = std::make_unique<ServerSource>(address, *token);
    if (source->valid()) return source;
  } catch (const std::exception&) {
    // The library throws for a port that is no number.
  }
  return fail(ErrorCode::kUsage, "--server: '" + url + "' is no address like http://127.0.0.1:8080");
}

}  // namespace evograsp::cli
