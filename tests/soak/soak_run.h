// One small run by real programs, the faults that befall it, and what must be true of its run.db all the
// while.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/random.h"
#include "common/socket.h"
#include "tests/server/cluster.h"
#include "tests/server/relay.h"
#include "tests/server/small_disk.h"
#include "tests/soak/soak_journal.h"

namespace evograsp::soak {

inline constexpr int kGenerations = 60, kPopulation = 24;

struct Undisturbed {
  std::string champion;
  Journal journal;
};

// What is special about a run beside its faults.
struct Conditions {
  bool keys = false;        // CURVE, with an allow-list
  bool small_disk = false;  // a file system of its own, which can fill and be made read-only
  bool flips = false;       // of bytes of run.db
  bool absence = false;     // the master is away for minutes, once
  // Of `number`: each kind of run comes round.
  static Conditions of(int number) { return {number % 2 == 1, number % 3 != 2, number % 3 == 2, false}; }
};

class SoakRun {
 public:
  SoakRun(const std::filesystem::path& folder, const Undisturbed* expected, Conditions conditions,
          std::uint64_t seed);
  ~SoakRun();

  // To the end, without a fault.
  Undisturbed undisturbed();
  // To the end, with a fault of random kind every so often; false when something that was promised did not
  // hold (said on stdout). counts: faults by kind, of those that took hold, added to.
  bool disturbed(std::map<std::string, int>& counts);
  std::uint64_t accepted() const { return accepted_; }  // evaluations, in all lives of the master

 private:
  // happen: makes the fault, true when it took hold. What shows only later is left to prove_later(); it
  // counts then.
  struct Fault {
    const char* name;
    int weight;
    bool (SoakRun::*happen)();
  };
  struct Member {
    std::unique_ptr<testing::Process> process;
    std::string name;
  };
  struct Proof {
    const char* kind;
    std::function<bool()> holds;
  };
  static const std::vector<Fault>& faults();
  const Fault& draw();

  std::filesystem::path run_dir() const { return home_ / "run"; }
  std::filesystem::path log_of(const std::string& name) const { return folder_ / (name + ".log"); }
  std::string log_text(const std::string& name) const { return testing::read_file(log_of(name)); }
  bool says(const std::string& name, const std::string& text) const;

  void make_keys();
  std::vector<std::string> settings() const;
  void start_server();  // goes on with the run where there is one
  void launch_server(bool resume);
  std::string server_name() const { return "server-" + std::to_string(server_starts_ - 1); }
  std::vector<std::string> worker_arguments(const std::string& name, bool through_relay) const;
  void start_worker(std::size_t slot, const std::string& fault);
  bool replace_worker(const std::string& fault, const std::string& proof);
  bool serves(std::size_t slot);
  std::size_t some_worker();
  void keep_workers();
  void end_everybody();
  void prove_later(std::function<bool()> holds) { proofs_.push_back({now_->name, std::move(holds)}); }
  void prove_later(const std::string& name, const std::string& text);
  void count_proven(std::map<std::string, int>& counts);

  bool remember();    // what is journalled just now, before the master goes
  bool check_kept();  // ... is there afterwards
  std::string audit_events() const;
  bool check_end();
  bool check_strangers();
  bool complain(const std::string& what);
  bool wait_for(const std::function<bool()>& condition, double seconds);

  // ---- the master (soak_faults.cpp) ----
  bool take_down();
  bool kill_server();
  bool stop_server();
  bool freeze_server();
  bool stay_away();
  // ---- workers ----
  bool kill_worker();
  bool preempt_worker();
  bool freeze_worker();
  bool slow_worker();
  bool lying_worker();
  bool hung_worker();
  bool crashing_worker();
  bool wrong_clock();
  bool twin_identity();
  bool other_build();
  // ---- the network ----
  bool cut_link();
  bool reset_link();
  bool lossy_link();
  // ---- strangers (soak_strangers.cpp) ----
  SocketOptions insider() const;
  bool other_protocol();
  bool garbage();
  bool half_open();
  bool tiny_frames();
  bool oversized_frame();
  bool replayed_bytes();
  bool wrong_key();
  bool no_key();
  bool knock(const SocketOptions& options);
  bool http_dawdler();
  bool http_without_token();
  bool http_path_tricks();
  int http(const std::string& request, std::string* answer = nullptr);
  // ---- the disk (soak_disk.cpp) ----
  bool full_disk();
  bool read_only_disk();
  bool flipped_byte();
  bool refused_in_one_line(int code);

  const std::filesystem::path folder_;
  std::filesystem::path home_;  // of the run folder
  const Undisturbed* expected_;
  const Conditions conditions_;
  Random random_;
  std::string endpoint_, http_endpoint_;
  std::unique_ptr<testing::SmallDisk> disk_;
  std::unique_ptr<testing::Relay> relay_;  // between the first worker and the master
  std::unique_ptr<testing::Process> server_;
  std::vector<Member> workers_;
  std::vector<Member> others_;              // uninvited, ended with the run
  std::vector<int> held_open_;              // sockets that say nothing
  std::vector<std::string> never_welcome_;  // names of those who must stay outside
  std::vector<Proof> proofs_;
  const Fault* now_ = nullptr;
  int server_starts_ = 0, worker_starts_ = 0;
  bool good_ = true;
  bool lied_ = false;     // a liar has been there
  bool tallied_ = false;  // the count of the journal has begun
  bool damaged_ = false;  // a byte of run.db was flipped and the run went on
  std::uint64_t accepted_ = 0;
  Journal seen_;  // everything that was ever committed to the journal
};

}  // namespace evograsp::soak
