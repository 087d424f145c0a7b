#include "server/api.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <charconv>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <thread>

#include "server/api_access.h"
#include "server/api_http.h"
#include "server/api_json.h"
#include "server/api_request.h"
#include "server/archive_json.h"
#include "server/metrics.h"

namespace evograsp::server {
namespace {

using httplib::Request;
using httplib::Response;
using nlohmann::json;

constexpr std::uint32_t kMostRows = 1000;  // a page
constexpr std::uint32_t kPage = 100;       // unless asked for another size

int status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
    case ErrorCode::kInvalid:
      return 409;  // asked properly, but the run is not in a state for it
    case ErrorCode::kNotFound:
      return 404;
    case ErrorCode::kUnavailable:
      return 503;
    default:
      return 500;
  }
}

const char* word_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
    case ErrorCode::kInvalid:
      return "conflict";
    case ErrorCode::kNotFound:
      return "not_found";
    case ErrorCode::kUnavailable:
      return "unavailable";
    case ErrorCode::kIo:
      return "io";
    default:
      return "internal";
  }
}

template <class T>
auto value_of(T result) {
  if (!result)
    throw HttpError{status_of(result.error().code), word_of(result.error().code), result.error().message};
  if constexpr (!std::is_void_v<typename T::value_type>) return std::move(*result);
}

void answer(Response& response, const json& document) {
  response.set_content(dump(document) + "\n", "application/json");
}

void answer_error(Response& response, const HttpError& error) {
  response.status = error.status;
  answer(response, {{"error", {{"code", error.code}, {"message", error.message}}}});
}

class Api final : public ApiServer {
 public:
  Api(ApiOptions options, RunControl& run, bool loopback)
      : options_(std::move(options)),
        strangers_(options_.strangers ? options_.strangers : std::make_shared<Strangers>()),
        run_(run),
        access_(loopback, options_.token),
        http_(limits(options_), [this](const std::string& peer) {
          strangers_->tell(Offence::kRequest, peer,
                           "at the HTTP port: a request too large, or never finished");
        }) {
    http_.set_pre_routing_handler([this](const Request& q, Response& r) { return admit(q, r); });
    http_.set_error_handler([](const Request& q, Response& r) {
      if (!r.body.empty()) return;
      const bool unknown = r.status == 404;
      answer_error(r, {r.status, unknown ? "not_found" : "invalid",
                       unknown ? "no such resource: " + q.path : "the request was not understood"});
    });
    http_.set_logger([this](const Request& q, const Response& r) {
      tell_refused(q, r);
      ++counts_[static_cast<std::size_t>(r.status / 100) % counts_.size()];
    });
    add_reads();
    add_changes();
    add_operations();
    for (const StaticFile& file : options_.files) add_file(file);
  }

  ~Api() override {
    http_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Status start(const HostPort& at) {
    port_ = http_.bind(at.host, at.port);
    if (port_ <= 0)
      return fail(ErrorCode::kIo, options_.listen +
                                      ": cannot listen for HTTP (port taken, or no such address); "
                                      "choose another with net.http");
    thread_ = std::thread([this] { http_.listen_after_bind(); });
    // stop() before the loop runs would be lost.
    while (!http_.is_running()) std::this_thread::yield();
    return {};
  }

  int port() const override { return port_; }

 private:
  using Handler = std::function<void(const Request&, Response&)>;

  static HttpLimits limits(const ApiOptions& options) {
    HttpLimits l;
    l.threads = options.threads;
    return l;
  }

  // ---- who may ----

  // Runs before anything of the body is read.
  httplib::Server::HandlerResponse admit(const Request& request, Response& response) {
    try {
      const auto known = methods_.find(request.path);
      if (known != methods_.end()) {
        const std::string method = request.method == "HEAD" ? "GET" : request.method;
        if (!known->second.contains(method)) {
          response.set_header("Allow", *known->second.begin());
          throw HttpError{405, "method", request.path + " does not take " + request.method};
        }
      }
      access_.check(request);
      // A few bytes of either can ask for gigabytes.
      if (request.has_header("Range"))
        throw HttpError{416, "range", "ranges are not served: ask for the whole"};
      if (request.has_header("Content-Encoding"))
        throw HttpError{415, "encoding", "send the body as it is, without Content-Encoding"};
    } catch (const HttpError& error) {
      if (error.status == 401) response.set_header("WWW-Authenticate", "Bearer");
      answer_error(response, error);
      return httplib::Server::HandlerResponse::Handled;
    }
    return httplib::Server::HandlerResponse::Unhandled;
  }

  // Runs after each answer.
  void tell_refused(const Request& request, const Response& response) {
    const auto tell = [&](Offence offence, const char* what) {
      strangers_->tell(offence, request.remote_addr, std::string("at the HTTP port: ") + what);
    };
    const bool known = methods_.contains(request.path);
    if (response.status == 401) return tell(Offence::kToken, "a change without the bearer token");
    if (response.status == 403) return tell(Offence::kOrigin, "a foreign Host or Origin");
    if (response.status == 404 && is_trick(request.path))
      return tell(Offence::kPath, "a path that leads out of the folder");
    if (response.status == 413 || (response.status == 400 && !known))
      tell(Offence::kRequest, "a request that is too large or no HTTP");
  }

  // ---- routes ----

  Handler guarded(Handler handler) {
    return [handler = std::move(handler)](const Request& request, Response& response) {
      try {
        handler(request, response);
      } catch (const HttpError& error) {
        answer_error(response, error);
      } catch (const std::exception& error) {
        spdlog::error("http: {}: {}", request.path, error.what());
        answer_error(response, {500, "internal", "the server failed to answer; its log says why"});
      }
    };
  }

  void get(const std::string& path, Handler handler) {
    methods_[path].insert("GET");
    http_.Get(as_pattern(path), guarded(std::move(handler)));
  }
  void post(const std::string& path, Handler handler) {
    methods_[path].insert("POST");
    http_.Post(as_pattern(path), guarded(std::move(handler)));
  }
  void put(const std::string& path, Handler handler) {
    methods_[path].insert("PUT");
    http_.Put(as_pattern(path), guarded(std::move(handler)));
  }

  void add_reads() {
    get("/api/v1/run", [this](const Request& q, Response& r) {
      allow_only(q, {});
      answer(r, run_json(*run_.snapshot()));
    });
    get("/api/v1/workers", [this](const Request& q, Response& r) {
      allow_only(q, {});
      answer(r, workers_json(*run_.snapshot()));
    });
    get("/api/v1/generations", [this](const Request& q, Response& r) { generations(q, r); });
    get("/api/v1/species", [this](const Request& q, Response& r) { species(q, r); });
    get("/api/v1/events", [this](const Request& q, Response& r) { events(q, r); });
    get("/api/v1/archive", [this](const Request& q, Response& r) {
      allow_only(q, {});
      answer(r, value_of(archive_json(reader())));
    });
    get("/api/v1/archive/champion", [this](const Request& q, Response& r) {
      allow_only(q, {"x", "y"});
      const auto x = query_number(q, "x", 0, kMostRows), y = query_number(q, "y", 0, kMostRows);
      const std::string bytes =
          value_of(elite_of(reader(), static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)));
      r.set_content(bytes, "application/x-protobuf");
    });
    get("/api/v1/champion", [this](const Request& q, Response& r) { champion(q, r); });
    get("/api/v1/log-level", [this](const Request&, Response& r) {
      answer(r, {{"level", run_.log_level()}});
    });
  }

  void add_changes() {
    const auto change = [this](const char* path, Status (RunControl::*verb)()) {
      post(path, [this, verb](const Request&, Response& r) {
        value_of((run_.*verb)());
        r.status = 202;
        answer(r, {{"accepted", true}});
      });
    };
    change("/api/v1/pause", &RunControl::pause);
    change("/api/v1/resume", &RunControl::resume);
    change("/api/v1/stop", &RunControl::stop);
    change("/api/v1/checkpoint", &RunControl::checkpoint);
    const auto drain = [this](const char* path, bool drained) {
      post(path, [this, drained](const Request& q, Response& r) {
        const std::string node = body_text(q, "node");
        const std::uint32_t workers = value_of(run_.drain(node, drained));
        r.status = 202;
        answer(r, {{"accepted", true}, {"workers", workers}});
      });
    };
    drain("/api/v1/workers/drain", true);
    drain("/api/v1/workers/undrain", false);
    put("/api/v1/log-level", [this](const Request& q, Response& r) {
      const std::string level = body_text(q, "level");
      static const std::set<std::string> kLevels{"trace", "debug", "info", "warn", "error", "off"};
      if (!kLevels.contains(level))
        bad("level: one of trace, debug, info, warn, error, off is needed, not '" + level + "'");
      value_of(run_.set_log_level(level));
      answer(r, {{"level", run_.log_level()}});
    });
  }

  void add_operations() {
    get("/healthz", [](const Request&, Response& r) { r.set_content("ok\n", "text/plain"); });
    get("/readyz", [this](const Request&, Response& r) {
      const auto snapshot = run_.snapshot();
      const bool ready = snapshot->ready && snapshot->state != RunState::kFailed;
      if (!ready) r.status = 503;
      const std::string why = snapshot->error.empty() ? "not ready\n" : "failed: " + snapshot->error + "\n";
      r.set_content(ready ? "ready\n" : why, "text/plain");
    });
    get("/metrics", [this](const Request&, Response& r) {
      HttpCounts counts{};
      for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = counts_[i].load();
      r.set_content(metrics_text(*run_.snapshot(), counts, strangers_->counts()),
                    "text/plain; version=0.0.4; charset=utf-8");
    });
  }

  void add_file(const StaticFile& file) {
    get(file.path, [&file](const Request&, Response& r) {
      if (file.gzipped) r.set_header("Content-Encoding", "gzip");
      r.set_header("Cache-Control", "no-cache");
      r.set_header("X-Content-Type-Options", "nosniff");
      r.set_header("Content-Security-Policy", "default-src 'self'; style-src 'self' 'unsafe-inline'");
      r.set_content(file.bytes, file.content_type);
    });
  }

  // ---- handlers that read run.db ----

  StoreReader& reader() {
    const MutexLock lock(reader_mutex_);
    if (reader_ == nullptr) reader_ = value_of(StoreReader::open(options_.run_dir));
    return *reader_;
  }

  void generations(const Request& q, Response& r) {
    allow_only(q, {"from", "limit"});
    const auto from = query_number(q, "from", 0, std::numeric_limits<std::uint32_t>::max());
    const auto limit = query_number(q, "limit", kPage, kMostRows);
    if (limit == 0) bad("limit: at least 1");
    auto page = value_of(
        reader().generations(static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(limit) + 1));
    const bool more = page.size() > limit;
    if (more) page.pop_back();
    answer(r, generations_json(page, more));
  }

  void species(const Request& q, Response& r) {
    allow_only(q, {"generation"});
    const auto last = value_of(reader().last_generation());
    if (!last) throw HttpError{404, "not_found", "no generation has been judged yet"};
    const auto generation =
        query_number(q, "generation", last->generation, std::numeric_limits<std::uint32_t>::max());
    if (generation > last->generation)
      throw HttpError{404, "not_found",
                      "generation " + std::to_string(generation) + " has not been judged yet"};
    const auto g = static_cast<std::uint32_t>(generation);
    answer(r, species_json(g, value_of(reader().species(g))));
  }

  void events(const Request& q, Response& r) {
    allow_only(q, {"since", "limit"});
    const auto since = static_cast<std::int64_t>(
        query_number(q, "since", 0, static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())));
    const auto limit = query_number(q, "limit", kPage, kMostRows);
    answer(r, events_json(value_of(reader().events(since, static_cast<std::uint32_t>(limit))), since));
  }

  void champion(const Request& q, Response& r) {
    allow_only(q, {"format"});
    const bool asked_bytes = q.get_header_value("Accept").find("application/x-protobuf") != std::string::npos;
    const std::string format = q.has_param("format") ? q.get_param_value("format")
                               : asked_bytes         ? "pb"
                                                     : "json";
    if (format != "pb" && format != "json") bad("format: pb or json is needed, not '" + format + "'");
    const auto snapshot = run_.snapshot();
    if (snapshot->champion == nullptr)
      throw HttpError{404, "not_found", "no champion yet: the first generation has not been judged"};
    r.set_header("X-Evograsp-Champion", snapshot->champion_chosen ? "chosen" : "best-so-far");
    if (format == "pb") {
      r.set_content(*snapshot->champion, "application/x-protobuf");
    } else {
      r.set_content(value_of(champion_json(*snapshot->champion)) + "\n", "application/json");
    }
  }

  const ApiOptions options_;
  const std::shared_ptr<Strangers> strangers_;
  RunControl& run_;
  const Access access_;
  std::map<std::string, std::set<std::string>> methods_;  // of each path; fixed once routes are added
  std::array<std::atomic<std::uint64_t>, 6> counts_{};

  Mutex reader_mutex_;
  std::unique_ptr<StoreReader> reader_ GUARDED_BY(reader_mutex_);  // made on first use; thread-safe itself

  HttpServer http_;
  int port_ = 0;
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<ApiServer>> ApiServer::create(ApiOptions options, RunControl& run) {
  HostPort at;
  if (!parse_host_port(options.listen, at))
    return fail(ErrorCode::kUsage, "net.http: '" + options.listen + "' is not host:port");
  if (!at.loopback() && options.token.empty() && !options.insecure)
    return fail(ErrorCode::kUsage,
                "net.http: " + options.listen +
                    " can be reached from outside: set a bearer token (net.http_token_file or "
                    "EVOGRASP_TOKEN), or say --insecure");
  auto api = std::make_unique<Api>(std::move(options), run, at.loopback());
  if (const Status started = api->start(at); !started) return tl::unexpected<Error>(started.error());
  return std::unique_ptr<ApiServer>(std::move(api));
}

}  // namespace evograsp::server
