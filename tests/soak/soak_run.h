// One small run by real programs, the faults that befall it, and what must be true of its run.db all the
// while.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/random.h"
#include "tests/server/cluster.h"
#include "tests/server/relay.h"

namespace evograsp::soak {

// Digest of the measurements of each (generation, genome) in a run.db.
using Journal = std::map<std::pair<std::uint32_t, std::uint64_t>, std::string>;
// Empty when the file cannot be read just now.
Journal read_journal(const std::filesystem::path& run_dir);

struct Undisturbed {
  std::string champion;
  Journal journal;
};

class SoakRun {
 public:
  SoakRun(const std::filesystem::path& folder, const Undisturbed* expected, std::uint64_t seed);
  ~SoakRun();

  // To the end, without a fault.
  Undisturbed undisturbed();
  // To the end, with a fault of random kind every so often; false when something that was promised did not
  // hold (said on stdout). counts: faults by kind, added to.
  bool disturbed(std::map<std::string, int>& counts);

 private:
  struct Fault {
    const char* name;
    int weight;
    void (SoakRun::*happen)();
  };
  static const std::vector<Fault>& faults();

  void start_server(bool resume);
  void start_worker(std::size_t slot, const std::string& fault, bool through_relay = false);
  bool check_resumed(const Journal& before);
  bool check_end();
  bool complain(const std::string& what);
  void keep_workers();
  std::size_t some_worker();

  void kill_server();
  void stop_server();
  void kill_worker();
  void preempt_worker();
  void freeze_worker();
  void slow_worker();
  void lying_worker();
  void cut_link();
  void twin_identity();
  void other_protocol();
  void garbage();
  void half_open();
  void wrong_clock();

  const std::filesystem::path folder_;
  const Undisturbed* expected_;
  Random random_;
  std::string endpoint_;
  std::unique_ptr<testing::Relay> relay_;
  std::unique_ptr<testing::Process> server_;
  std::vector<std::unique_ptr<testing::Process>> workers_;
  std::vector<std::unique_ptr<testing::Process>> others_;  // uninvited, ended with the run
  std::vector<int> held_open_;                             // sockets that say nothing
  int server_starts_ = 0, worker_starts_ = 0;
  bool good_ = true;
  Journal seen_;  // everything that was ever committed to the journal
};

}  // namespace evograsp::soak
