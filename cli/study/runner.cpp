#include "cli/study/runner.h"

#include <algorithm>
#include <thread>

#include "cli/inputs.h"
#include "common/config_check.h"
#include "server/store.h"

namespace evograsp::cli::study {

namespace fs = std::filesystem;

namespace {

// The config by name, else the file beside the study.
std::string config_file(const LoadedStudy& study, const std::string& config) {
  std::error_code error;
  const fs::path beside = study.base / config;
  return !study.base.empty() && fs::is_regular_file(beside, error) ? beside.string() : config;
}

// What decides the run's bytes, as text: neither addresses nor how work is spread, nor its name, nor what the
// program itself counts when the run begins.
std::vector<std::pair<std::string, std::string>> meaning(proto::Config config) {
  config.clear_net();
  config.clear_dispatch();
  config.clear_store();
  config.mutable_run()->clear_name();
  config.mutable_neat()->clear_other_inputs();
  auto values = flatten(config);
  // A file is the same wherever it lies: the run keeps its name without the folder.
  for (auto& [key, value] : values) {
    const std::size_t slash = value.rfind('/');
    if (slash != std::string::npos && (key.starts_with("scene.object") || key == "grasp.hand"))
      value = value.substr(slash + 1);
    std::erase(value, '"');
  }
  return values;
}

}  // namespace

tl::expected<void, Diagnostics> Runner::prepare(const std::vector<PlannedRun>& plan) {
  prepared_.clear();
  for (const PlannedRun& run : plan) {
    auto loaded = load_config(config_file(study_, run.config), run.overrides, known_names());
    if (!loaded) {
      Diagnostics mistakes = loaded.error();
      for (Diagnostic& mistake : mistakes) mistake.message += " (run " + run.id + " of " + study_.file + ")";
      return tl::unexpected(mistakes);
    }
    loaded->config.mutable_run()->set_name((study_.name + "-" + run.id).substr(0, kLongestRunName));
    close_doors(*loaded);
    prepared_.push_back({run, std::move(*loaded)});
  }
  return {};
}

int Runner::slots_of(const PlannedRun& plan) const {
  if (plan.slots > 0) return plan.slots;
  return options_.slots > 0 ? options_.slots
                            : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

Status Runner::check_same(const Prepared& prepared, const RunFolder& run) const {
  const auto wanted = meaning(prepared.loaded.config), found = meaning(run.info.config);
  if (wanted == found) return {};
  std::string difference;
  for (const auto& entry : wanted) {
    if (std::ranges::find(found, entry) != found.end()) continue;
    difference = ": " + entry.first + " would be " + entry.second;
    break;
  }
  return fail(ErrorCode::kInvalid, run.path.string() + ": was run with other settings" + difference +
                                       "; name another folder by --out, or remove this one");
}

Result<server::RunState> Runner::evolve(server::ServerOptions options, int slots) {
  auto run = LocalRun::create(std::move(options), slots);
  if (!run) return tl::unexpected(run.error());
  {
    const MutexLock lock(mutex_);
    under_way_ = run->get();
    if (stopped_) under_way_->stop();
  }
  auto state = (*run)->run([this](const server::GenerationReport& report) { progress_.generation(report); });
  const MutexLock lock(mutex_);
  under_way_ = nullptr;
  return state;
}

void Runner::stop() {
  stopped_ = true;
  const MutexLock lock(mutex_);
  if (under_way_ != nullptr) under_way_->stop();
}

// Evolves what is missing of a run. kUnavailable: stopped on the way.
Result<RunFolder> Runner::finished(const Prepared& prepared) {
  const fs::path folder = folder_of(prepared.plan);
  std::error_code error;
  const bool resume = server::Store::holds_run(folder);
  if (resume) {
    auto run = read_run_folder(folder);
    if (!run) return run;
    if (auto status = check_same(prepared, *run); !status) return tl::unexpected(status.error());
    if (run->state == "finished") {
      if (fs::exists(folder / "champion.pb", error)) return run;
      if (auto status = write_results(*run); !status) return tl::unexpected(status.error());
      return run;
    }
  }
  if (stopped_) return fail(ErrorCode::kUnavailable, "stopped");
  auto options = resume ? resumed_run(folder) : new_run(prepared.loaded, folder);
  if (!options) return tl::unexpected(options.error());
  const auto state = evolve(std::move(*options), slots_of(prepared.plan));
  if (!state) return fail(state.error().code, folder.string() + ": " + state.error().message);
  if (*state == server::RunState::kStopped) return fail(ErrorCode::kUnavailable, "stopped");
  if (*state != server::RunState::kFinished)
    return fail(ErrorCode::kInternal, folder.string() + ": the run failed; its events say why");
  auto run = read_run_folder(folder);
  if (!run) return run;
  if (auto status = write_results(*run); !status) return tl::unexpected(status.error());
  return run;
}

// Names of the program, or files beside the study.
std::vector<std::string> Runner::objects_of(const PlannedRun& plan) const {
  const proto::StudyTest& test = study_.study.test();
  if (test.folder()) return options_.folder_objects;
  std::vector<std::string> objects(test.object().begin(), test.object().end());
  if (objects.empty()) objects = plan.test_objects;
  for (std::string& object : objects) {
    std::error_code error;
    if (fs::is_regular_file(study_.base / object, error)) object = (study_.base / object).string();
  }
  return objects;
}

Result<DoneRun> Runner::one(const Prepared& prepared) {
  auto run = finished(prepared);
  if (!run) return tl::unexpected(run.error());
  MeasureOptions how;
  how.study = study_.study;
  how.objects = objects_of(prepared.plan);
  how.scale = options_.scale;
  how.mass = options_.mass;
  how.threads = options_.slots;
  how.stop = &stopped_;
  how.tell = [this](const std::string& what) { progress_.measuring(what); };
  auto measured = measure(*run, how);
  if (!measured) return tl::unexpected(measured.error());
  return DoneRun{prepared.plan, slots_of(prepared.plan), std::move(*run), std::move(*measured)};
}

Result<std::vector<DoneRun>> Runner::run_all() {
  std::vector<PlannedWork> work;
  for (const Prepared& p : prepared_) {
    const proto::Config& c = p.loaded.config;
    const double targets = c.trials().every_object() ? c.scene().object_size() : 1;
    std::string kind = p.plan.id.substr(0, p.plan.id.rfind('-') + 1);
    work.push_back({p.plan.id, std::move(kind), c.run().generations(),
                    targets * c.trials().scenes() * c.trials().clicks() * c.neat().population() *
                        c.run().generations()});
  }
  progress_.begin(std::move(work));
  std::vector<DoneRun> done;
  for (std::size_t i = 0; i < prepared_.size(); ++i) {
    progress_.start(i);
    auto result = one(prepared_[i]);
    if (!result && result.error().code == ErrorCode::kUnavailable && stopped_)
      continue;  // later ones may be whole
    if (!result) return tl::unexpected(result.error());
    progress_.done(i, result->run);
    done.push_back(std::move(*result));
  }
  progress_.finish();
  return done;
}

}  // namespace evograsp::cli::study
