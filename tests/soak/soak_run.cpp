#include "tests/soak/soak_run.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "common/zap.h"
#include "server/champion_file.h"

namespace evograsp::soak {

namespace fs = std::filesystem;
using testing::Process;

namespace {

constexpr std::size_t kWorkers = 3;
constexpr double kRoundSeconds = 240;  // a run that takes longer has stalled
constexpr char kToken[] = "EVOGRASP_TOKEN=soak-0123456789abcdef";

}  // namespace

SoakRun::SoakRun(const fs::path& folder, const Undisturbed* expected, Conditions conditions,
                 std::uint64_t seed)
    : folder_(folder),
      home_(folder),
      expected_(expected),
      conditions_(conditions),
      random_(seed, Purpose::kTestHarness),
      endpoint_(testing::free_endpoint()),
      http_endpoint_(testing::free_endpoint()),
      workers_(kWorkers) {
  fs::create_directories(folder_ / "disk");
  if (conditions_.small_disk) {
    disk_ = std::make_unique<testing::SmallDisk>(folder_ / "disk", "64m");
    if (disk_->mounted())
      home_ = disk_->path();
    else
      disk_.reset();
  }
  if (conditions_.keys) make_keys();
  relay_ = std::make_unique<testing::Relay>(endpoint_, testing::Relay::Link{0.005, 1e8});
}

SoakRun::~SoakRun() {
  for (const int fd : held_open_) close(fd);
  end_everybody();
}

void SoakRun::end_everybody() {
  server_.reset();
  workers_.clear();
  others_.clear();
}

bool SoakRun::says(const std::string& name, const std::string& text) const {
  return log_text(name).find(text) != std::string::npos;
}

bool SoakRun::wait_for(const std::function<bool()>& condition, double seconds) {
  return testing::eventually(condition, seconds);
}

// ---- programs ----

void SoakRun::make_keys() {
  const auto master = generate_keys(folder_ / "master.key", "");
  const auto worker = generate_keys(folder_ / "worker.key", master->public_key);
  generate_keys(folder_ / "enemy.key", master->public_key).value();
  std::ofstream(folder_ / "allowed") << worker->public_key << " every worker\n";
}

std::vector<std::string> SoakRun::settings() const {
  std::vector<std::string> all = {"run.generations=" + std::to_string(kGenerations),
                                  "neat.population=" + std::to_string(kPopulation),
                                  "trials.scenes=3",
                                  "champion.candidates=4",
                                  "champion.validation_trials=6",
                                  "scene.object=cube_6cm",
                                  "store.journal_seconds=0.01",
                                  "store.journal_trials=true",
                                  "dispatch.audit_share=1",
                                  "dispatch.task_deadline=3"};
  if (conditions_.keys) {
    all.push_back("net.curve_secret_key_file=" + (folder_ / "master.key").string());
    all.push_back("net.curve_allow_file=" + (folder_ / "allowed").string());
  }
  return all;
}

void SoakRun::launch_server(bool resume) {
  std::vector<std::string> arguments = {"--listen", endpoint_, "--http",
                                        http_endpoint_.substr(std::string("tcp://").size())};
  if (resume) {
    arguments.insert(arguments.end(), {"--resume", run_dir().string()});
  } else {
    arguments.insert(arguments.end(), {"--config", EVOGRASP_SOURCE_DIR "/configs/quick.txtpb", "--run-dir",
                                       run_dir().string()});
    for (const std::string& value : settings()) arguments.insert(arguments.end(), {"--set", value});
  }
  const std::string name = "server-" + std::to_string(server_starts_++);
  server_ =
      std::make_unique<Process>("evograsp-server", arguments, log_of(name), std::vector<std::string>{kToken});
}

void SoakRun::start_server() {
  const auto begun = [&] {
    const auto committed = server::StoreReader::open(run_dir());
    return committed && (*committed)->run();
  };
  // Killed before its first commit, there is nothing to resume.
  launch_server(begun());
  if (tallied_) return;
  wait_for([&] { return (tallied_ = begun() && Tally::begin(run_dir())) || server_->ended(); }, 20);
}

std::vector<std::string> SoakRun::worker_arguments(const std::string& name, bool through_relay) const {
  std::vector<std::string> arguments = {"--connect",       through_relay ? relay_->endpoint() : endpoint_,
                                        "--identity",      name,
                                        "--slots",         "1",
                                        "--drain-seconds", "1"};
  if (conditions_.keys)
    arguments.insert(arguments.end(), {"--curve-key-file", (folder_ / "worker.key").string()});
  return arguments;
}

// The first worker is always behind the relay.
void SoakRun::start_worker(std::size_t slot, const std::string& fault) {
  const std::string name = "worker-" + std::to_string(worker_starts_++);
  workers_[slot].name = name;
  workers_[slot].process =
      std::make_unique<Process>("evograsp-worker-faulty", worker_arguments(name, slot == 0), log_of(name),
                                std::vector<std::string>{"EVOGRASP_FAULT=" + fault});
}

bool SoakRun::serves(std::size_t slot) {
  return !workers_[slot].process->ended() && says(workers_[slot].name, "welcome");
}

std::size_t SoakRun::some_worker() {
  return random_.below(static_cast<std::uint32_t>(workers_.size()));
}

void SoakRun::keep_workers() {
  for (std::size_t i = 0; i < workers_.size(); ++i)
    if (!workers_[i].process || workers_[i].process->ended()) start_worker(i, "sleep:0.004");
}

// ---- a run ----

Undisturbed SoakRun::undisturbed() {
  start_server();
  // Two, since every result is compared.
  Process one("evograsp-worker", worker_arguments("one", false), log_of("one"));
  Process other("evograsp-worker", worker_arguments("other", false), log_of("other"));
  if (server_->finish() != 0) std::printf("the undisturbed run failed:\n%s\n", server_->log().c_str());
  return {testing::read_file(run_dir() / server::kChampionFile),
          read_journal(run_dir(), kGenerations).value_or(Journal{})};
}

const SoakRun::Fault& SoakRun::draw() {
  int total = 0;
  for (const Fault& fault : faults()) total += fault.weight;
  int drawn = static_cast<int>(random_.below(static_cast<std::uint32_t>(total)));
  for (const Fault& fault : faults()) {
    drawn -= fault.weight;
    if (drawn < 0) return fault;
  }
  return faults().front();
}

bool SoakRun::disturbed(std::map<std::string, int>& counts) {
  start_server();
  keep_workers();
  const auto start = std::chrono::steady_clock::now();
  const double limit = kRoundSeconds + (conditions_.absence ? 200 : 0);
  bool away = !conditions_.absence;
  while (good_ && !server_->ended()) {
    if (std::chrono::steady_clock::now() - start > std::chrono::duration<double>(limit))
      return complain("the run does not come to its end");
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + random_.below(500)));
    keep_workers();
    if (server_->ended()) break;
    static const Fault kAbsence = {"master away for 150 s", 0, &SoakRun::stay_away};
    now_ = away ? &draw() : &kAbsence;
    if ((this->*now_->happen)()) {
      ++counts[now_->name];
      if (now_ == &kAbsence) away = true;
    }
  }
  const bool good = good_ && check_end();
  count_proven(counts);
  return good;
}

void SoakRun::prove_later(const std::string& name, const std::string& text) {
  prove_later([this, name, text] { return says(name, text); });
}

void SoakRun::count_proven(std::map<std::string, int>& counts) {
  for (const Proof& proof : proofs_)
    if (proof.holds()) ++counts[proof.kind];
}

// ---- what must be true ----

bool SoakRun::complain(const std::string& what) {
  std::printf("FAILED: %s%s%s\n%s\n", what.c_str(), now_ != nullptr ? "; the last fault: " : "",
              now_ != nullptr ? now_->name : "", server_ ? server_->log().c_str() : "");
  good_ = false;
  return false;
}

// False when run.db cannot be read yet, or no more. An evaluation never changes.
bool SoakRun::remember() {
  const auto journal = read_journal(run_dir(), kGenerations, damaged_);
  if (!journal) return false;
  for (const auto& [key, digest] : *journal) {
    const auto known = seen_.emplace(key, digest);
    if (!known.second && known.first->second != digest)
      return complain("a journalled evaluation has changed: generation " + std::to_string(key.first));
  }
  return true;
}

// What the run has to say of results that were compared, one line each.
std::string SoakRun::audit_events() const {
  std::string lines;
  auto reader = server::StoreReader::open(run_dir());
  const auto events = reader ? (*reader)->events(0, 100000) : Result<std::vector<server::Event>>();
  if (!events) return {};
  for (const server::Event& event : *events)
    if (event.kind.starts_with("audit") || event.kind == "unaudited" || event.kind == "quarantine")
      lines += event.kind + ": " + event.text + "\n";
  return lines;
}

// What was committed to the journal while the server lived is there afterwards, with the same bytes, and has
// come in once.
bool SoakRun::check_kept() {
  const Journal before = seen_;
  if (!remember()) return good_ && (before.empty() || complain("run.db cannot be read any more"));
  const Journal after = read_journal(run_dir(), kGenerations, damaged_).value_or(Journal{});
  for (const auto& [key, digest] : before)
    if (!after.contains(key))
      return complain("a journalled evaluation is gone: generation " + std::to_string(key.first) +
                      ", genome " + std::to_string(key.second));
  if (tallied_)
    if (const std::string wrong = Tally::verdict(run_dir()); !wrong.empty())
      return complain("an evaluation did not count once: " + wrong);
  return true;
}

bool SoakRun::check_end() {
  if (server_->finish() != 0) return complain("the server failed");
  if (!tallied_) return complain("nobody counted the evaluations");
  if (!check_kept() || !check_strangers()) return false;
  const auto journal = read_journal(run_dir(), kGenerations, damaged_);
  if (!journal) return complain("run.db cannot be read");
  for (const auto& [key, digest] : *journal)
    if (!expected_->journal.contains(key) || expected_->journal.at(key) != digest)
      return complain("the evaluation of genome " + std::to_string(key.second) + " of generation " +
                      std::to_string(key.first) + " differs from the undisturbed run's\n" + audit_events());
  if (!damaged_ && journal->size() != expected_->journal.size()) return complain("an evaluation is missing");
  if (testing::read_file(run_dir() / server::kChampionFile) != expected_->champion)
    return complain("the champion differs from the undisturbed run's");
  accepted_ = Tally::accepted(run_dir());
  return good_;
}

bool SoakRun::check_strangers() {
  for (const std::string& name : never_welcome_)
    if (says(name, "welcome")) return complain(name + " was let in");
  return true;
}

}  // namespace evograsp::soak
