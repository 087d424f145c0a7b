#include "worker/evaluator.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "common/network_pack.h"
#include "sim/lift.h"
#include "worker/steps.h"

namespace evograsp::worker {

namespace {

// What a master never asks for: its wish would take the worker's memory, or its slot for good.
constexpr std::size_t kMostMeasurements = 1 << 18;
constexpr double kLongestNoop = 60;  // s

// Each network takes its time, however many come in one task.
double noop_time(const proto::Task& task) {
  return task.noop_seconds() * task.network_size();
}

std::string refusal(const proto::Task& task, std::size_t networks) {
  if (static_cast<std::size_t>(task.network_size()) != networks)
    return "a task of " + std::to_string(task.network_size()) + " networks came with " +
           std::to_string(networks);
  const std::size_t measurements = networks * static_cast<std::size_t>(task.trial_size());
  if (measurements > kMostMeasurements)
    return "a task of " + std::to_string(measurements) + " trials, more than " +
           std::to_string(kMostMeasurements);
  if (task.has_noop_seconds() && !(noop_time(task) <= kLongestNoop))
    return "a task that waits longer than " + std::to_string(static_cast<int>(kLongestNoop)) + " s";
  return {};
}

}  // namespace

proto::Measurement to_proto(const sim::Measurement& m) {
  proto::Measurement out;
  out.set_outcome(m.outcome);
  out.set_quality(m.quality);
  out.set_contacts(static_cast<std::uint32_t>(m.contacts));
  out.set_obstructions(static_cast<std::uint32_t>(m.obstructions));
  *out.mutable_p() = evograsp::to_proto(m.p);
  *out.mutable_s() = evograsp::to_proto(m.s);
  *out.mutable_o() = evograsp::to_proto(m.o);
  out.set_nearest_object(m.nearest_object);
  out.set_target_distance(m.target_distance);
  out.set_theta(m.theta);
  return out;
}

Evaluator::Evaluator(std::shared_ptr<SharedSimulator> shared) : shared_(std::move(shared)) {
  if (!shared_) return;
  workspace_ = shared_->simulator->make_workspace();
  const proto::HandBundle& hand = shared_->simulator->hand();
  if (hand.has_approach_axis()) approach_axis_ = from_proto(hand.approach_axis()).normalized();
}

Evaluator::~Evaluator() = default;

void Evaluator::evaluate(const proto::Task& task, const std::vector<zmq::message_t>& networks,
                         proto::TaskResult& result) {
  if (const std::string why = refusal(task, networks.size()); !why.empty()) {
    result.set_error(why);
  } else if (task.has_noop_seconds()) {
    if (task.noop_seconds() > 0) std::this_thread::sleep_for(std::chrono::duration<double>(noop_time(task)));
    for (int i = 0; i < task.network_size() * task.trial_size(); ++i) result.add_measurement();
  } else if (!shared_) {
    result.set_error("this worker has no simulator");
  } else {
    try {
      simulate(task, networks, result);
    } catch (const std::exception& error) {
      result.set_error(error.what());
    }
  }
  if (result.has_error()) result.clear_measurement();
}

void Evaluator::simulate(const proto::Task& task, const std::vector<zmq::message_t>& networks,
                         proto::TaskResult& result) {
  gather(task, result);
  for (std::size_t i = 0; i < networks.size(); ++i) {
    const Result<Network> network = compile(networks[i]);
    if (!network) {
      result.set_error("network " + std::to_string(task.network(static_cast<int>(i))) + ": " +
                       network.error().message);
      return;
    }
    measure(*network, result);
  }
}

// The task's scenarios, and their input vectors row by row.
void Evaluator::gather(const proto::Task& task, proto::TaskResult& result) {
  std::vector<const proto::TrialKey*> keys;
  for (const proto::TrialKey& key : task.trial()) keys.push_back(&key);
  scenarios_ = shared_->scenarios.get(task.trial_set())->prepare(*shared_->simulator, keys);
  const auto width = static_cast<std::size_t>(shared_->simulator->inputs());
  inputs_.assign(scenarios_.size() * width, 0);
  outputs_.assign(scenarios_.size() * sim::kOutputs, 0);
  for (std::size_t i = 0; i < scenarios_.size(); ++i) {
    const Scenario& scenario = *scenarios_[i];
    if (scenario.fault.empty())
      std::copy(scenario.inputs.begin(), scenario.inputs.end(),
                inputs_.begin() + static_cast<long>(i * width));
    else
      result.set_notice(scenario.fault);
  }
}

Result<Network> Evaluator::compile(const zmq::message_t& bytes) const {
  Result<Network> network = unpack_network(bytes.to_string_view());
  if (!network) return network;
  if (network->inputs() != shared_->simulator->inputs() || network->outputs() != sim::kOutputs)
    return fail(ErrorCode::kInvalid, std::to_string(network->inputs()) + " inputs and " +
                                         std::to_string(network->outputs()) + " outputs, the simulator has " +
                                         std::to_string(shared_->simulator->inputs()) + " and " +
                                         std::to_string(sim::kOutputs));
  return network;
}

void Evaluator::measure(const Network& network, proto::TaskResult& result) {
  const sim::Simulator& simulator = *shared_->simulator;
  const bool box = simulator.experiment().trials().bounding_box();
  network.activate_batch(inputs_, outputs_, static_cast<int>(scenarios_.size()), scratch_, kRecurrentSteps);
  for (std::size_t i = 0; i < scenarios_.size(); ++i) {
    const Scenario& scenario = *scenarios_[i];
    if (!scenario.fault.empty()) {
      result.add_measurement()->set_outcome(proto::NO_TRIAL);
      continue;
    }
    const std::span<const float> outputs(outputs_.data() + i * sim::kOutputs, sim::kOutputs);
    const Pose tool = simulator.decode(outputs, scenario.info, box);
    sim::GraspReport report;
    const sim::Measurement measured = simulator.get_quality(scenario.placements, scenario.target, tool,
                                                            *workspace_, scenario.lift ? &report : nullptr);
    proto::Measurement& out = *result.add_measurement();
    out = to_proto(measured);
    if (scenario.approach && measured.outcome != proto::NOT_A_NUMBER)
      *out.mutable_approach() = evograsp::to_proto(Vec3(tool.rotation * approach_axis_));
    if (!scenario.lift) continue;
    const bool closed = measured.outcome == proto::GRASPED && measured.quality > 0;
    const auto lifted = closed ? sim::lift_test(simulator, scenario.placements, scenario.target, report)
                               : Result<sim::LiftReport>();
    out.set_held(closed && lifted && lifted->held);
  }
}

void Evaluator::step(const proto::StepRequest& request, proto::StepReply& reply) {
  reply.set_id(request.id());
  reply.set_client(request.client());
  if (!shared_)
    reply.set_error("this worker has no simulator");
  else
    answer_step(*shared_->simulator, *workspace_, request, reply);
}

}  // namespace evograsp::worker
