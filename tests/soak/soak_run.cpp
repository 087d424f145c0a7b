#include "tests/soak/soak_run.h"

#include <cstdio>

#include "server/champion_file.h"
#include "server/store_reader.h"

namespace evograsp::soak {

namespace fs = std::filesystem;
using testing::Process;

namespace {

constexpr std::size_t kWorkers = 3;
constexpr int kGenerations = 60, kPopulation = 24;
constexpr double kRoundSeconds = 240;  // a run that takes longer has stalled

std::vector<std::string> settings() {
  return {"run.generations=" + std::to_string(kGenerations), "neat.population=" + std::to_string(kPopulation),
          "trials.scenes=3", "champion.candidates=4", "champion.validation_trials=6", "scene.object=cube_6cm",
          "store.journal_seconds=0.01", "store.journal_trials=true", "dispatch.audit_share=1",
          "dispatch.task_deadline=5",
          // Three workers killed by hand with the same suspect would make it poison: see docs/PROTOCOL.md.
          "dispatch.poison_strikes=1000"};
}

}  // namespace

Journal read_journal(const fs::path& run_dir) {
  Journal journal;
  auto reader = server::StoreReader::open(run_dir);
  if (!reader) return journal;
  for (std::uint32_t generation = 0; generation < kGenerations; ++generation) {
    const auto rows = (*reader)->evaluations(generation);
    if (!rows) return {};
    for (const server::Evaluation& row : *rows)
      journal[{generation, row.genome}] = sha256_hex(row.measurements);
  }
  return journal;
}

SoakRun::SoakRun(const fs::path& folder, const Undisturbed* expected, std::uint64_t seed)
    : folder_(folder),
      expected_(expected),
      random_(seed, Purpose::kTestHarness),
      endpoint_(testing::free_endpoint()),
      workers_(kWorkers) {
  fs::create_directories(folder_);
  relay_ = std::make_unique<testing::Relay>(endpoint_, testing::Relay::Link{0.005, 1e8});
}

SoakRun::~SoakRun() {
  for (const int fd : held_open_) close(fd);
}

void SoakRun::start_server(bool resume) {
  std::vector<std::string> arguments = {"--listen", endpoint_, "--http", ""};
  // Killed before its first commit, there is nothing to resume.
  const auto committed = server::StoreReader::open(folder_ / "run");
  if (resume && committed && (*committed)->run()) {
    arguments.insert(arguments.end(), {"--resume", (folder_ / "run").string()});
  } else {
    arguments.insert(arguments.end(), {"--config", EVOGRASP_SOURCE_DIR "/configs/quick.txtpb", "--run-dir",
                                       (folder_ / "run").string()});
    for (const std::string& value : settings()) arguments.insert(arguments.end(), {"--set", value});
  }
  const std::string name = "server-" + std::to_string(server_starts_++);
  server_ = std::make_unique<Process>("evograsp-server", arguments, folder_ / name);
}

void SoakRun::start_worker(std::size_t slot, const std::string& fault, bool through_relay) {
  const std::string name = "worker-" + std::to_string(worker_starts_++);
  workers_[slot] = std::make_unique<Process>(
      "evograsp-worker-faulty",
      std::vector<std::string>{"--connect", through_relay ? relay_->endpoint() : endpoint_, "--identity",
                               name, "--slots", "1", "--drain-seconds", "1"},
      folder_ / name, std::vector<std::string>{"EVOGRASP_FAULT=" + fault});
}

Undisturbed SoakRun::undisturbed() {
  start_server(false);
  Process worker("evograsp-worker", {"--connect", endpoint_, "--slots", "2"}, folder_ / "worker");
  if (server_->finish() != 0) std::printf("the undisturbed run failed:\n%s\n", server_->log().c_str());
  return {testing::read_file(folder_ / "run" / server::kChampionFile), read_journal(folder_ / "run")};
}

bool SoakRun::complain(const std::string& what) {
  std::printf("FAILED: %s\n%s\n", what.c_str(), server_ ? server_->log().c_str() : "");
  good_ = false;
  return false;
}

void SoakRun::keep_workers() {
  for (std::size_t i = 0; i < workers_.size(); ++i)
    if (!workers_[i] || workers_[i]->ended()) start_worker(i, "sleep:0.004", i == 0);
}

bool SoakRun::disturbed(std::map<std::string, int>& counts) {
  start_server(false);
  keep_workers();
  const auto start = std::chrono::steady_clock::now();
  while (good_ && !server_->ended()) {
    if (std::chrono::steady_clock::now() - start > std::chrono::duration<double>(kRoundSeconds))
      return complain("the run does not come to its end");
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + random_.below(500)));
    keep_workers();
    int total = 0;
    for (const Fault& fault : faults()) total += fault.weight;
    int drawn = static_cast<int>(random_.below(static_cast<std::uint32_t>(total)));
    const auto chosen = std::find_if(faults().begin(), faults().end(), [&](const Fault& fault) {
      drawn -= fault.weight;
      return drawn < 0;
    });
    if (server_->ended()) break;
    ++counts[chosen->name];
    (this->*chosen->happen)();
  }
  return good_ && check_end();
}

// What was committed to the journal before the server died is there afterwards, with the same bytes, and is
// not done again.
bool SoakRun::check_resumed(const Journal& before) {
  for (const auto& [key, digest] : before) {
    const auto known = seen_.emplace(key, digest);
    if (!known.second && known.first->second != digest)
      return complain("a journalled evaluation has changed: generation " + std::to_string(key.first));
  }
  for (const auto& [key, digest] : seen_)
    if (!before.contains(key))
      return complain("a journalled evaluation is gone: generation " + std::to_string(key.first) +
                      ", genome " + std::to_string(key.second));
  return true;
}

bool SoakRun::check_end() {
  if (server_->finish() != 0) return complain("the server failed");
  const Journal journal = read_journal(folder_ / "run");
  check_resumed(journal);
  if (journal != expected_->journal) return complain("an evaluation differs from the undisturbed run's");
  if (testing::read_file(folder_ / "run" / server::kChampionFile) != expected_->champion)
    return complain("the champion differs from the undisturbed run's");
  auto reader = server::StoreReader::open(folder_ / "run");
  const auto last = reader ? (*reader)->last_generation() : decltype((*reader)->last_generation()){};
  const std::uint64_t wanted = std::uint64_t{kGenerations} * kPopulation;
  if (!last || !*last || (*last)->evaluations != wanted || journal.size() != wanted)
    return complain("not every evaluation was counted once");
  return good_;
}

}  // namespace evograsp::soak
