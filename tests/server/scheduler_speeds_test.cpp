// Workers of different speeds, played through in a time of the test's own: how long does a generation take?
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>

#include "server/scheduler.h"

namespace evograsp::server {
namespace {

constexpr double kTick = 0.02;  // as often as a dispatcher looks for overdue tasks

// One slot each, one generation after the other.
class Cluster {
 public:
  Cluster(std::vector<double> trial_seconds, bool declared) : speeds_(std::move(trial_seconds)) {
    for (std::size_t w = 0; w < speeds_.size(); ++w) {
      scheduler_.join(id(w), 1);
      if (declared) scheduler_.set_estimate(id(w), speeds_[w]);
    }
  }
  // Seconds until all is evaluated.
  double generation(std::uint32_t networks, std::uint32_t trials) {
    const double start = now_;
    scheduler_.begin(networks, trials);
    for (std::uint32_t i = 0; i < networks; ++i) scheduler_.add(i, 2000);
    while (!scheduler_.finished()) {
      give();
      advance();
    }
    for (auto& [worker, queue] : queues_) {
      queue.erase(queue.begin() + (running_.count(worker) ? 1 : 0),
                  queue.end());  // cancelled, but for what runs
    }
    return now_ - start;
  }
  // What perfect sharing would take.
  double ideal(double work_trials) const {
    double rate = 0;
    for (const double seconds : speeds_) rate += 1 / seconds;
    return work_trials / rate;
  }

 private:
  static WorkerId id(std::size_t w) { return static_cast<WorkerId>(w + 1); }
  double cost(WorkerId worker, const Assignment& what) const {
    return speeds_[worker - 1] * what.trials * static_cast<double>(what.networks.size());
  }

  void give() {
    for (bool given = true; given;) {
      given = false;
      for (std::size_t w = 0; w < speeds_.size(); ++w)
        if (const auto what = scheduler_.next(id(w), now_)) {
          queues_[id(w)].push_back(*what);
          given = true;
        }
    }
    for (auto& [worker, queue] : queues_)
      if (!running_.count(worker) && !queue.empty()) begin(worker);
  }

  void begin(WorkerId worker) {
    const Assignment& what = queues_[worker].front();
    running_[worker] = now_ + cost(worker, what);
    if (cost(worker, what) > 0.005) scheduler_.started(worker, what.task, what.attempt, now_);
  }

  // To the next end of a task, or the next tick.
  void advance() {
    double next = now_ + kTick;
    WorkerId worker = 0;
    for (const auto& [w, end] : running_)
      if (end < next) {
        next = end;
        worker = w;
      }
    now_ = next;
    if (worker == 0) return;
    running_.erase(worker);
    const Assignment what = queues_[worker].front();
    queues_[worker].pop_front();
    if (!scheduler_.find(worker, what.task, what.attempt)) return;
    const auto accepted = scheduler_.result(worker, what.task, cost(worker, what));
    for (const WorkerId other : accepted.cancel) {
      auto& queue = queues_[other];
      const auto first = queue.begin() + (running_.count(other) ? 1 : 0);
      queue.erase(
          std::remove_if(first, queue.end(), [&](const Assignment& a) { return a.task == what.task; }),
          queue.end());
    }
  }

  std::vector<double> speeds_;
  Scheduler scheduler_{SchedulerOptions()};
  std::map<WorkerId, std::deque<Assignment>> queues_;
  std::map<WorkerId, double> running_;  // when it ends
  double now_ = 0;
};

TEST(SchedulerSpeeds, AWorkerTenTimesSlowerHoldsUpNoGeneration) {
  for (const double trial : {0.0002, 0.002, 0.02}) {
    Cluster cluster({trial, trial, trial, 10 * trial}, true);
    for (int g = 0; g < 5; ++g) {
      const double ideal = cluster.ideal(100 * 20);
      // The last tasks of the fast ones, and of the slow one what it cannot be relieved of in time.
      EXPECT_LT(cluster.generation(100, 20), 1.05 * ideal + 2 * kTick + 2 * trial)
          << trial << " s, generation " << g;
    }
  }
}

TEST(SchedulerSpeeds, OneTrialThatTakesASlowWorkerLongIsDoneAgainByAFastOne) {
  Cluster cluster({0.05, 0.05, 0.05, 0.5}, true);
  cluster.generation(40, 5);
  const double ideal = cluster.ideal(40 * 5);
  EXPECT_LT(cluster.generation(40, 5), 1.05 * ideal + 0.05 + 3 * kTick);
}

TEST(SchedulerSpeeds, WithoutADeclarationTheFirstGenerationAloneIsLonger) {
  Cluster cluster({0.002, 0.002, 0.002, 0.02}, false);
  cluster.generation(100, 20);
  EXPECT_LT(cluster.generation(100, 20), 1.05 * cluster.ideal(100 * 20) + 2 * kTick);
}

TEST(SchedulerSpeeds, EqualWorkersEndTogether) {
  Cluster cluster(std::vector<double>(64, 0.01), true);
  EXPECT_LT(cluster.generation(200, 20), 1.05 * cluster.ideal(200 * 20) + 0.05);
}

}  // namespace
}  // namespace evograsp::server
