#include "cli/server_answers.h"

#include <utility>

#include "cli/json_input.h"
#include "cli/queries.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;

class ServerSource final : public Source {
 public:
  ServerSource(std::string url, AskServer ask) : url_(std::move(url)), ask_(std::move(ask)) {}

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
    auto answer = ask("GET", "/api/v1/champion?format=pb");
    if (!answer) return tl::unexpected(answer.error());
    return Champion{std::move(answer->body), answer->champion == "chosen"};
  }

  Result<json> archive() override { return document("/api/v1/archive"); }
  Result<Champion> elite(std::uint32_t x, std::uint32_t y) override {
    auto answer = ask("GET", "/api/v1/archive/champion?x=" + std::to_string(x) + "&y=" + std::to_string(y));
    if (!answer) return tl::unexpected(answer.error());
    return Champion{std::move(answer->body), false};
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
  Result<HttpAnswer> ask(const char* method, const std::string& path, const json& body = nullptr) {
    auto answer =
        ask_(method, path, body.is_null() ? "" : body.dump(-1, ' ', false, json::error_handler_t::replace));
    if (!answer || answer->status < 300) return answer;
    return refusal(*answer);
  }

  Result<json> parsed(const Result<HttpAnswer>& answer) const {
    if (!answer) return tl::unexpected(answer.error());
    json document = parse_json(answer->body);
    if (!document.is_object()) return not_ours();
    return document;
  }

  tl::unexpected<Error> refusal(const HttpAnswer& answer) const {
    const json body = parse_json(answer.body);
    if (!part_in(part_in(body, "error"), "message").is_string()) return not_ours();
    const std::string message = text_in(part_in(body, "error"), "message");
    switch (answer.status) {
      case 401:
        return fail(ErrorCode::kUsage,
                    url_ + ": " + message + "; put it into a file and set EVOGRASP_TOKEN_FILE to its name");
      case 404:
        return fail(ErrorCode::kNotFound, url_ + ": " + message);
      case 503:
        return fail(ErrorCode::kUnavailable, url_ + ": " + message);
      default:
        return fail(answer.status < 500 ? ErrorCode::kInvalid : ErrorCode::kIo, url_ + ": " + message);
    }
  }

  tl::unexpected<Error> not_ours() const {
    return fail(
        ErrorCode::kUnavailable,
        url_ + ": something answers, but it is no evograsp server; check --server or $EVOGRASP_SERVER");
  }

  const std::string url_;
  const AskServer ask_;
};

}  // namespace

std::unique_ptr<Source> server_source(std::string url, AskServer ask) {
  return std::make_unique<ServerSource>(std::move(url), std::move(ask));
}

}  // namespace evograsp::cli
