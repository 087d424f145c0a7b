// Every run of a study, one after the other, in folders of their own; what was done before is not done again.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <vector>

#include "cli/local_run.h"
#include "cli/run_folder.h"
#include "cli/study/measure.h"
#include "cli/study/progress.h"
#include "cli/study/study.h"
#include "common/mutex.h"

namespace evograsp::cli::study {

// What is known of a planned run.
struct DoneRun {
  PlannedRun plan;
  int slots = 0;  // it ran with
  RunFolder run;
  Measured measured;
};

struct RunnerOptions {
  std::filesystem::path out;
  int slots = 0;                            // 0: one a core
  std::vector<std::string> folder_objects;  // of --objects-from
  double scale = 0, mass = 0;               // of meshes among them
};

class Runner {
 public:
  Runner(const LoadedStudy& study, RunnerOptions options, StudyProgress& progress)
      : study_(study), options_(std::move(options)), progress_(progress) {}

  // The config of every run, or the mistakes in them. Before anything runs.
  tl::expected<void, Diagnostics> prepare(const std::vector<PlannedRun>& plan);
  // The finished runs, in the order of the plan; fewer than planned when stop() was called. A run that cannot
  // be evolved or tested is an error, and so is a folder whose run has other settings.
  Result<std::vector<DoneRun>> run_all();
  void stop();  // any thread: the run under way commits what it has
  bool stopped() const { return stopped_; }

 private:
  struct Prepared {
    PlannedRun plan;
    LoadedConfig loaded;
  };
  std::filesystem::path folder_of(const PlannedRun& plan) const { return options_.out / "runs" / plan.id; }
  int slots_of(const PlannedRun& plan) const;
  Result<RunFolder> finished(const Prepared& prepared);
  Status check_same(const Prepared& prepared, const RunFolder& run) const;
  Result<server::RunState> evolve(server::ServerOptions options, int slots);
  Result<DoneRun> one(const Prepared& prepared);
  std::vector<std::string> objects_of(const PlannedRun& plan) const;

  const LoadedStudy& study_;
  const RunnerOptions options_;
  StudyProgress& progress_;
  std::vector<Prepared> prepared_;
  std::atomic<bool> stopped_{false};
  Mutex mutex_;
  LocalRun* under_way_ GUARDED_BY(mutex_) = nullptr;
};

}  // namespace evograsp::cli::study
