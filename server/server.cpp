#include "server/server.h"

#include <atomic>
#include <new>
#include <random>
#include <thread>
#include <utility>
#include <zmq.hpp>

#include "common/config_check.h"
#include "common/digest.h"
#include "common/last_words.h"
#include "common/log.h"
#include "common/version.h"
#include "common/view_features.h"
#include "common/watchdog.h"
#include "server/api.h"
#include "server/champion_file.h"
#include "server/publisher.h"
#include "server/run_control.h"
#include "server/run_loop.h"
#include "server/security.h"
#include "server/snapshot.h"

namespace evograsp::server {

namespace {

constexpr int kNetworkOutputs = 7;  // position, axis, angle

std::uint64_t new_run_id() {
  std::random_device device;
  return (static_cast<std::uint64_t>(device()) << 32) | device();
}

// Everything that create() has opened.
struct Parts {
  ResumePoint start;
  std::unique_ptr<Store> store;
  std::unique_ptr<neat::Population> population;
  std::unique_ptr<score::Scorer> scorer;
  std::optional<score::GraspMap> map;  // of runs with an archive
};

std::vector<StoredAsset> pack(const assets::ResolvedExperiment& experiment) {
  std::vector<StoredAsset> packed;
  for (int i = 0; i < static_cast<int>(experiment.objects.size()); ++i) {
    const proto::ObjectBundle& object = experiment.objects[static_cast<std::size_t>(i)];
    packed.push_back(
        {experiment.experiment.object_id(i), "object", object.name(), assets::pack_bundle(object)});
  }
  packed.push_back({experiment.experiment.hand_id(), "hand", experiment.hand.name(),
                    assets::pack_bundle(experiment.hand)});
  return packed;
}

Result<Parts> start_new(const ServerOptions& options) {
  proto::Config config = options.config;
  config.mutable_neat()->set_other_inputs(other_inputs(config.camera()));
  const int inputs = static_cast<int>(network_inputs(config.camera()));
  auto population = neat::Population::create(config.neat(), inputs, kNetworkOutputs, config.run().seed());
  if (!population) return tl::unexpected(population.error());
  NewRun run;
  run.info.run_id = new_run_id();
  run.info.name = config.run().name();
  run.info.build = kVersion;
  run.info.config = config;
  run.info.experiment = options.experiment.experiment;
  run.assets = pack(options.experiment);
  run.population = population->save();
  Parts parts;
  parts.start.info = run.info;
  parts.start.assets = run.assets;
  parts.start.epoch = 1;
  parts.population = std::make_unique<neat::Population>(std::move(*population));
  auto store = Store::create(options.run_dir, std::move(run));
  if (!store) return tl::unexpected(store.error());
  parts.store = std::move(*store);
  return parts;
}

Result<Parts> start_again(const ServerOptions& options) {
  auto resumed = Store::resume(options.run_dir);
  if (!resumed) return tl::unexpected(resumed.error());
  Parts parts;
  parts.start = std::move(resumed->point);
  parts.store = std::move(resumed->store);
  proto::Config config = parts.start.info.config;
  config.clear_net();  // of the server that made the run; this one has its own
  std::string wrong;
  check_config(config, [&](const std::string& key, const std::string& why) {
    if (wrong.empty()) wrong = key + ": " + why;
  });
  if (!wrong.empty())
    return fail(ErrorCode::kInvalid,
                (options.run_dir / kStoreFile).string() + ": its config cannot be: " + wrong);
  auto population = neat::Population::load(parts.start.info.config.neat(), parts.start.population);
  if (!population) return tl::unexpected(population.error());
  parts.population = std::make_unique<neat::Population>(std::move(*population));
  for (const std::string& warning : parts.start.warnings) spdlog::warn("{}", warning);
  return parts;
}

Result<Parts> open_parts(const ServerOptions& options) {
  auto parts = options.resume ? start_again(options) : start_new(options);
  if (!parts) return parts;
  parts->start.info.config.mutable_net()->MergeFrom(options.net);
  auto scorer = score::Scorer::create(parts->start.info.config.fitness());
  if (!scorer) return tl::unexpected(scorer.error());
  parts->scorer = std::make_unique<score::Scorer>(*scorer);
  if (parts->start.info.config.neat().has_archive()) {
    const auto map = score::GraspMap::create(parts->start.info.config.neat().archive());
    if (!map) return tl::unexpected(map.error());
    parts->map = *map;
  }
  return parts;
}

DispatcherOptions dispatcher_options(const ResumePoint& start, bool inproc) {
  const proto::Config& config = start.info.config;
  DispatcherOptions options;
  if (!config.net().listen().empty()) options.endpoints.push_back(config.net().listen());
  if (inproc) options.endpoints.push_back("inproc://evograsp");
  options.scheduler = {config.dispatch().task_seconds(), config.dispatch().credit(),
                       config.dispatch().task_deadline(), config.dispatch().poison_strikes(),
                       config.dispatch().speculate()};
  options.stamp = {start.info.run_id, start.epoch};
  options.heartbeat_seconds = config.net().heartbeat_seconds();
  options.silence_seconds = config.net().silence_seconds();
  options.audit_share = config.dispatch().audit_share();
  options.audits_required = options.audit_share >= 1 && !inproc;
  options.experiment = start.info.experiment;
  for (const StoredAsset& asset : start.assets) options.assets.push_back({asset.id, asset.packed});
  return options;
}

class ServerImpl : public Server {
 public:
  ServerImpl(const ServerOptions& options, Parts parts)
      : run_dir_(options.run_dir),
        shared_context_(options.context),
        start_(std::move(parts.start)),
        store_(std::move(parts.store)),
        population_(std::move(parts.population)),
        scorer_(std::move(parts.scorer)),
        gather_(*scorer_, *store_, parts.map),
        snapshots_(start_, run_dir_) {}

  // The threads of others end before what they lean on.
  ~ServerImpl() override {
    api_.reset();
    // Workers that end with the run (--once) shall not end because it is interrupted: they lose the
    // connection and look for whoever goes on with it.
    if (dispatcher_ && state_ == RunState::kFailed) dispatcher_->dismiss("the run has failed");
    dispatcher_.reset();
    store_.reset();
  }

  Status open() {
    const proto::NetConfig& net = start_.info.config.net();
    if (shared_context_ == nullptr) own_context_ = std::make_unique<zmq::context_t>(1);
    zmq::context_t& context = shared_context_ != nullptr ? *shared_context_ : *own_context_;
    DispatcherOptions options = dispatcher_options(start_, shared_context_ != nullptr);
    options.strangers = strangers_;
    if (Status status = security_.open(context, net, options); !status) return status;
    auto dispatcher = Dispatcher::create(context, std::move(options), gather_);
    if (!dispatcher) return tl::unexpected(dispatcher.error());
    dispatcher_ = std::move(*dispatcher);
    if (Status status = publisher_.open(context, net, security_, strangers_); !status) return status;
    loop_ = std::make_unique<RunLoop>(
        start_, std::move(*population_), *store_, *dispatcher_, gather_,
        RunLoop::Callbacks{[this](const GenerationReport& r) { announce(r); }, [this] { publish(); }});
    publish();
    if (net.http().empty()) return {};
    return open_http(net);
  }

  // ---- Server ----

  void on_generation(std::function<void(const GenerationReport&)> callback) override {
    on_generation_ = std::move(callback);
  }

  Result<RunState> run() override {
    state_ = RunState::kRunning;
    if (!start_.champion.empty()) return finish_again();
    Result<RunState> end = loop_->run();
    if (end && *end == RunState::kFinished) {
      champion_ = loop_->position().champion;
      publisher_.publish(*champion_);
      if (Status status = write_champion(run_dir_, *champion_); !status) end = tl::unexpected(status.error());
    }
    if (!end) {
      snapshots_.set_error(end.error().message);
      store_->set_state("failed");
    }
    state_ = end ? *end : RunState::kFailed;
    publish();
    if (end && *end == RunState::kFinished) dispatcher_->dismiss("the run is finished");
    return end;
  }

  void stop() override { loop_->stop(); }

  Result<proto::Champion> champion() const override {
    if (champion_) return *champion_;
    return fail(ErrorCode::kNotFound, run_dir_.string() + ": no champion yet");
  }
  std::vector<std::string> endpoints() const override { return dispatcher_->endpoints(); }
  int http_port() const override { return api_ ? api_->port() : 0; }
  std::string http_listen() const override { return start_.info.config.net().http(); }
  RunControl& control() override { return control_; }

 private:
  // The same run, seen from the API.
  class Control : public RunControl {
   public:
    explicit Control(ServerImpl& server) : server_(server) {}
    std::shared_ptr<const RunSnapshot> snapshot() const override { return server_.snapshots_.last(); }
    Status pause() override { return server_.set_paused(true); }
    Status resume() override { return server_.set_paused(false); }
    Result<std::uint32_t> drain(const std::string& node, bool drained) override {
      return server_.drain(node, drained);
    }
    Status stop() override {
      if (server_.ended()) return fail(ErrorCode::kInvalid, "the run has ended");
      server_.stop();
      return {};
    }
    Status checkpoint() override { return server_.store_->flush(); }
    std::string log_level() const override { return evograsp::log_level(); }
    Status set_log_level(const std::string& level) override {
      if (evograsp::set_log_level(level)) return {};
      return fail(ErrorCode::kInvalid, "'" + level + "' is none of trace, debug, info, warn, error, off");
    }

   private:
    ServerImpl& server_;
  };

  Status open_http(const proto::NetConfig& net) {
    auto token = load_token(net.http_token_file());
    if (!token) return tl::unexpected(token.error());
    ApiOptions options;
    options.listen = net.http();
    options.token = *token;
    options.insecure = net.insecure();
    options.run_dir = run_dir_;
    options.strangers = strangers_;
    auto api = ApiServer::create(std::move(options), control_);
    if (!api) return tl::unexpected(api.error());
    api_ = std::move(*api);
    return {};
  }

  // A finished run that was resumed: nothing to do but to hand out what it found.
  Result<RunState> finish_again() {
    proto::Champion champion;
    if (!champion.ParseFromString(start_.champion))
      return fail(ErrorCode::kInvalid, run_dir_.string() + ": the stored champion does not parse");
    champion_ = std::move(champion);
    if (Status status = write_champion(run_dir_, *champion_); !status) return tl::unexpected(status.error());
    store_->set_state("finished");
    state_ = RunState::kFinished;
    publish();
    return RunState::kFinished;
  }

  Status set_paused(bool paused) {
    if (ended()) return fail(ErrorCode::kInvalid, "the run has ended");
    loop_->set_paused(paused);
    return {};
  }

  Result<std::uint32_t> drain(const std::string& node, bool drained) {
    std::uint32_t meant = 0;
    for (const WorkerView& worker : snapshots_.last()->workers)
      if (worker.state != "gone" && (worker.host == node || worker.identity == node)) ++meant;
    if (meant == 0)
      return fail(ErrorCode::kNotFound, "no worker is called '" + node + "' or is on a host of that name");
    dispatcher_->set_drained(node, drained);
    return meant;
  }

  bool ended() const {
    const RunState state = state_;
    return state != RunState::kRunning && state != RunState::kPaused;
  }

  // On the run loop's thread.
  void announce(const GenerationReport& report) {
    spdlog::info("generation {}: best {:.4f}, mean {:.4f}, {} species, {} trials", report.generation,
                 report.best, report.mean, report.species, report.trials);
    publisher_.publish(start_, loop_->position());
    if (on_generation_) on_generation_(report);
  }

  void publish() {
    watchdog_.beat();
    publisher_.look_at_door();
    const RunState state = ended() ? state_.load() : loop_->paused() ? RunState::kPaused : RunState::kRunning;
    snapshots_.publish(state, loop_->position(), champion_, dispatcher_->view(), gather_, store_->figures());
  }

  const std::filesystem::path run_dir_;
  std::unique_ptr<zmq::context_t> own_context_;
  zmq::context_t* const shared_context_;
  ResumePoint start_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<neat::Population> population_;  // until the loop takes it
  std::unique_ptr<score::Scorer> scorer_;
  Gather gather_;
  Control control_{*this};
  Snapshots snapshots_;
  const std::shared_ptr<Strangers> strangers_ = std::make_shared<Strangers>();
  Security security_;
  std::unique_ptr<RunLoop> loop_;
  Publisher publisher_;
  std::unique_ptr<Dispatcher> dispatcher_;
  std::unique_ptr<ApiServer> api_;
  std::function<void(const GenerationReport&)> on_generation_;
  std::optional<proto::Champion> champion_;
  Watchdog watchdog_;
  std::atomic<RunState> state_{RunState::kRunning};
};

}  // namespace

Result<std::unique_ptr<Server>> Server::create(ServerOptions options) {
  try {
    auto parts = open_parts(options);
    if (!parts) return tl::unexpected(parts.error());
    auto server = std::make_unique<ServerImpl>(options, std::move(*parts));
    if (Status status = server->open(); !status) return tl::unexpected(status.error());
    return server;
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kIo, "not enough memory for this run on this machine");
  } catch (const std::exception& error) {
    return tl::unexpected(error_of_exception(error));
  }
}

}  // namespace evograsp::server
