// A small run by the real programs, because only they can be killed.
#pragma once

#include "server/champion_file.h"
#include "server/store_reader.h"
#include "tests/server/cluster.h"
#include "tests/server/relay.h"

namespace evograsp::testing {

inline constexpr char kQuickConfig[] = EVOGRASP_SOURCE_DIR "/configs/quick.txtpb";

class RealRun : public ::testing::Test {
 protected:
  // `settings`: NAME=VALUE of the config, beside those of small_run().
  std::vector<std::string> server_arguments(const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> arguments = {"--config", kQuickConfig, "--run-dir", run_dir().string(),
                                          "--listen", endpoint_,    "--http",    http_};
    std::vector<std::string> all = small_run(generations_);
    all.insert(all.end(), settings.begin(), settings.end());
    for (const std::string& value : all) {
      if (value.rfind("net.listen", 0) == 0 || value.rfind("net.http=", 0) == 0) continue;
      arguments.push_back("--set");
      arguments.push_back(value);
    }
    return arguments;
  }
  std::vector<std::string> resume_arguments() const {
    return {"--resume", run_dir().string(), "--listen", endpoint_, "--http", http_};
  }
  std::filesystem::path run_dir() const { return dir_.path() / "run"; }
  std::filesystem::path log(const std::string& name) const { return dir_.path() / name; }
  std::unique_ptr<Process> start_worker(const std::string& name, int slots = 1) const {
    return std::make_unique<Process>("evograsp-worker", worker_arguments(name, slots), log(name));
  }
  // See tests/worker/faulty_main.cpp.
  // host: what it says its machine is; empty: this one.
  std::unique_ptr<Process> start_faulty(const std::string& name, const std::string& fault,
                                        const std::string& host = {}) const {
    std::vector<std::string> environment = {"EVOGRASP_FAULT=" + fault};
    if (!host.empty()) environment.push_back("EVOGRASP_HOST=" + host);
    return std::make_unique<Process>("evograsp-worker-faulty", worker_arguments(name, 1), log(name),
                                     environment);
  }
  std::vector<std::string> worker_arguments(const std::string& name, int slots) const {
    return {"--connect",          relay_ ? relay_->endpoint() : endpoint_, "--identity", name, "--slots",
            std::to_string(slots)};
  }
  std::string champion() const { return read_file(run_dir() / server::kChampionFile); }
  // What run.db says happened, of one kind.
  std::vector<std::string> events(const std::string& kind) const {
    std::vector<std::string> texts;
    auto reader = server::StoreReader::open(run_dir());
    if (!reader) return texts;
    const auto all = (*reader)->events(0, 100000);
    if (!all) return texts;
    for (const server::Event& event : *all)
      if (event.kind == kind) texts.push_back(event.text);
    return texts;
  }
  // Starts workers and returns when the server has them all.
  void wait_for_welcome(const Process& worker) const {
    EXPECT_TRUE(eventually([&] { return worker.log().find("welcome") != std::string::npos; }))
        << worker.log();
  }
  // What the run comes to when nothing goes wrong.
  std::string undisturbed(const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> all = small_run(generations_);
    all.insert(all.end(), settings.begin(), settings.end());
    const auto loaded = load_config(kQuickConfig, all);
    return loaded ? champion_of(loaded->config, {2}) : "";
  }

  int generations_ = 40;
  TempDir dir_;
  std::string endpoint_ = free_endpoint();
  // On a network that loses packets (tests/platforms/lossy_test.sh) the links are late as well, 50 ms each
  // way.
  std::unique_ptr<Relay> relay_ = std::getenv("EVOGRASP_LOSSY") == nullptr
                                      ? nullptr
                                      : std::make_unique<Relay>(endpoint_, Relay::Link{0.05, 1e9});
  std::string http_;  // the server's HTTP address; empty: none
};

}  // namespace evograsp::testing
