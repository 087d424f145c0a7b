// evograsp-soak [--minutes M] [--seed S]: runs with random faults, one after the other, until the time is up.
// Each must end with the champion, and the evaluations, of the undisturbed run. Exit 0: all did.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/log.h"
#include "tests/soak/soak_run.h"

namespace evograsp::soak {
namespace {

constexpr double kLongSoak = 10;  // minutes: from here on the master is also away for 150 s, once

int soak(int argc, char** argv) {
  double minutes = 20;
  std::uint64_t seed = 1;
  CLI::App app("Random faults against real programs, for as long as you like.", "evograsp-soak");
  app.add_option("--minutes", minutes, "how long")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--seed", seed, "of the faults")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);

  testing::own_mounts();  // before there are threads
  testing::TempDir folder;
  const auto start = std::chrono::steady_clock::now();
  const auto passed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const Undisturbed expected = SoakRun(folder.path() / "undisturbed", nullptr, {}, 0).undisturbed();
  if (expected.champion.empty() || expected.journal.empty()) return 1;
  std::printf("undisturbed: %zu evaluations in %.1f s, champion %.12s\n", expected.journal.size(), passed(),
              sha256_hex(expected.champion).c_str());

  std::map<std::string, int> counts;
  std::uint64_t accepted = 0;
  int runs = 0;
  bool good = true;
  while (good && passed() < minutes * 60) {
    const std::filesystem::path run = folder.path() / ("run-" + std::to_string(runs));
    Conditions conditions = Conditions::of(runs);
    conditions.absence = runs == 1 && minutes >= kLongSoak;
    {
      SoakRun one(run, &expected, conditions,
                  hash_key(seed, Purpose::kTestHarness, 0, static_cast<std::uint64_t>(runs)));
      good = one.disturbed(counts);
      accepted += one.accepted();
    }
    std::filesystem::remove_all(run);
    ++runs;
    int faults = 0;
    for (const auto& [name, count] : counts) faults += count;
    std::printf("%6.0f s: run %d %s, %d faults so far\n", passed(), runs, good ? "equal" : "FAILED", faults);
  }
  std::printf("\n%d runs in %.0f s; faults that took hold, by kind:\n", runs, passed());
  for (const auto& [name, count] : counts) std::printf("  %-30s %5d\n", name.c_str(), count);
  if (good)
    std::printf(
        "every champion, and each of %zu evaluations of every run, equals the undisturbed run's;\n"
        "%llu evaluations were accepted by %d runs: none was lost, none was counted twice\n",
        expected.journal.size(), static_cast<unsigned long long>(accepted), runs);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace evograsp::soak

int main(int argc, char** argv) {
  return evograsp::soak::soak(argc, argv);
}
