// Servers and workers for tests: in this process, and as real ones that can be killed.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "assets/assets.h"
#include "common/config.h"
#include "common/digest.h"
#include "server/server.h"
#include "worker/worker.h"

namespace evograsp::testing {

class TempDir {
 public:
  TempDir() {
    std::string name = (std::filesystem::temp_directory_path() / "evograsp-test-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~TempDir() { std::filesystem::remove_all(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// What a small run sets apart from the defaults.
inline std::vector<std::string> small_run(int generations = 40) {
  return {"run.generations=" + std::to_string(generations),
          "neat.population=24",
          "trials.scenes=3",
          "champion.candidates=4",
          "champion.validation_trials=6",
          "net.listen=tcp://127.0.0.1:*",
          "net.http=",
          "scene.object=cube_6cm",
          "camera.feature=CENTROID,SIZE",
          "race.rounds=2",
          "lift.finalists=2",
          "lift.finalist_trials=1",
          "lift.generations=1",
          "lift.candidates=2",
          "lift.trials=1",
          "store.journal_seconds=0.01"};
}

inline proto::Config small_config(int generations = 40) {
  proto::Config config;
  auto loaded = load_config(EVOGRASP_SOURCE_DIR "/configs/quick.txtpb", small_run(generations));
  if (!loaded) {
    for (const Diagnostic& d : loaded.error()) ADD_FAILURE() << d.text();
    return config;
  }
  return loaded->config;
}

inline server::ServerOptions server_options(const proto::Config& config,
                                            const std::filesystem::path& run_dir) {
  server::ServerOptions options;
  options.config = config;
  options.run_dir = run_dir;
  auto experiment = assets::resolve_experiment(config, EVOGRASP_SOURCE_DIR "/configs");
  if (experiment)
    options.experiment = *experiment;
  else
    ADD_FAILURE() << experiment.error().message;
  return options;
}

// A worker on a thread of this process.
class WorkerThread {
 public:
  WorkerThread(zmq::context_t* context, const std::string& endpoint, int slots,
               const std::string& identity = {}) {
    worker::WorkerOptions options;
    options.connect = endpoint;
    options.slots = slots;
    options.identity = identity;
    options.context = context;
    worker_ = std::move(*worker::Worker::create(options));
    thread_ = std::thread([this] { status_ = worker_->run(); });
  }
  ~WorkerThread() {
    if (thread_.joinable()) {
      worker_->stop();
      thread_.join();
    }
  }
  worker::Worker& operator*() { return *worker_; }
  Status join() {
    thread_.join();
    return status_;
  }

 private:
  std::unique_ptr<worker::Worker> worker_;
  Status status_;
  std::thread thread_;
};

// Runs a server with in-process workers to its end; gives the champion's bytes.
inline std::string champion_of(const proto::Config& config, const std::vector<int>& worker_slots) {
  TempDir dir;
  zmq::context_t context(1);
  server::ServerOptions options = server_options(config, dir.path() / "run");
  options.context = &context;
  auto server = server::Server::create(options);
  if (!server) {
    ADD_FAILURE() << server.error().message;
    return {};
  }
  std::vector<std::unique_ptr<WorkerThread>> workers;
  for (const int slots : worker_slots)
    workers.push_back(std::make_unique<WorkerThread>(&context, "inproc://evograsp", slots));
  const auto end = (*server)->run();
  if (!end) {
    ADD_FAILURE() << end.error().message;
    return {};
  }
  return deterministic_bytes(*(*server)->champion());
}

inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

// A program of the build, on its own.
class Process {
 public:
  // environment: "NAME=VALUE", beside what this process has.
  Process(const std::string& program, const std::vector<std::string>& arguments, std::filesystem::path log,
          const std::vector<std::string>& environment = {})
      : log_(std::move(log)) {
    // A path is taken as it is.
    std::vector<std::string> words = {
        program.find('/') == std::string::npos ? std::string(EVOGRASP_BIN_DIR) + "/" + program : program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const std::string& variable : environment) putenv(const_cast<char*>(variable.c_str()));
    const int out = open(log_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    dup2(out, 1);
    dup2(out, 2);
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~Process() { finish(SIGKILL); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) { kill(pid_, number); }
  bool ended() {
    int status = 0;
    if (!done_ && waitpid(pid_, &status, WNOHANG) == pid_) {
      done_ = true;
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
    return done_;
  }
  // Exit code, or -signal.
  int finish(int number = 0) {
    if (done_) return code_;
    if (number != 0) {
      kill(pid_, SIGCONT);
      kill(pid_, number);
    }
    int status = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (std::chrono::steady_clock::now() > end) {
        ADD_FAILURE() << "process " << pid_ << " does not end:\n" << log();
        kill(pid_, SIGKILL);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    done_ = true;
    code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    return code_;
  }
  std::string log() const { return read_file(log_); }

 private:
  std::filesystem::path log_;
  pid_t pid_ = -1;
  bool done_ = false;
  int code_ = 0;
};

inline bool eventually(const std::function<bool()>& condition, double seconds = 20) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

// A loopback port that was free a moment ago.
inline std::string free_endpoint() {
  zmq::context_t context(1);
  zmq::socket_t socket(context, zmq::socket_type::router);
  socket.bind("tcp://127.0.0.1:*");
  return socket.get(zmq::sockopt::last_endpoint);
}

}  // namespace evograsp::testing
