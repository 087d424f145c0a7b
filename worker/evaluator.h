// Runs a task: compile each network, then look, decide and grasp on every trial. One a slot; not thread-safe.
#pragma once

#include <memory>
#include <vector>
#include <zmq.hpp>

#include "common/network.h"
#include "proto/wire.pb.h"
#include "sim/simulator.h"
#include "worker/scenarios.h"

namespace evograsp::worker {

// What the slots of a worker share: a simulator and the scenarios prepared with it. Thread-safe.
struct SharedSimulator {
  std::shared_ptr<const sim::Simulator> simulator;
  ScenarioCache scenarios;
};

class Evaluator {
 public:
  // shared may be null: then only no-op tasks can be done.
  explicit Evaluator(std::shared_ptr<SharedSimulator> shared);
  ~Evaluator();

  // Fills the measurements (networks x trials, trials fastest), or the error. Never throws.
  void evaluate(const proto::Task& task, const std::vector<zmq::message_t>& networks,
                proto::TaskResult& result);
  // One of the three commands. The request says which scene and target it is about: nothing is remembered.
  void step(const proto::StepRequest& request, proto::StepReply& reply);

 private:
  void simulate(const proto::Task& task, const std::vector<zmq::message_t>& networks,
                proto::TaskResult& result);
  void gather(const proto::Task& task, proto::TaskResult& result);
  void measure(const Network& network, proto::TaskResult& result);
  Result<Network> compile(const zmq::message_t& bytes) const;

  std::shared_ptr<SharedSimulator> shared_;
  std::unique_ptr<sim::Workspace> workspace_;
  Vec3 approach_axis_ = Vec3(0, 0, 1);  // of the palm
  Network::Scratch scratch_;
  std::vector<std::shared_ptr<const Scenario>> scenarios_;
  std::vector<float> inputs_, outputs_;  // a row a trial
};

proto::Measurement to_proto(const sim::Measurement& m);

}  // namespace evograsp::worker
