// A task or a stepwise command from a master, as a slot does it: piece 1 the task or the request, the rest
// networks.
#include "common/wire.h"
#include "tests/fuzz/simulate.h"
#include "worker/evaluator.h"

namespace {

using namespace evograsp;

std::shared_ptr<const sim::Simulator> simulator() {
  const auto& experiment = fuzz::small_experiment();
  static const auto made =
      *sim::Simulator::create(experiment.experiment, experiment.objects, experiment.hand);
  return made;
}

// Long work and long waits are legal; the search has no time for them.
bool quick(const proto::Task& task) {
  return task.noop_seconds() < 0.001 && task.trial_size() <= 4 && task.network_size() <= 4;
}

void evaluate(worker::Evaluator& evaluator, const proto::Task& task, fuzz::Pieces& pieces) {
  if (!quick(task)) return;
  std::vector<zmq::message_t> networks;
  while (!pieces.empty()) networks.push_back(to_frame(pieces.bytes()));
  proto::TaskResult result;
  evaluator.evaluate(task, networks, result);
  fuzz::require(result.has_error() ? result.measurement_size() == 0
                                   : result.measurement_size() == task.network_size() * task.trial_size(),
                "an error, or every measurement");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Pieces pieces(data, size);
  const std::uint8_t kind = pieces.byte();
  const std::string_view bytes = pieces.bytes();
  auto shared = std::make_shared<worker::SharedSimulator>();
  shared->simulator = simulator();
  worker::Evaluator evaluator(kind % 4 == 3 ? nullptr : shared);
  if (kind % 4 == 0) {
    proto::StepRequest request;
    proto::StepReply reply;
    if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return 0;
    evaluator.step(request, reply);
    fuzz::require(reply.id() == request.id(), "an answer names its request");
    fuzz::require(reply.has_error() != (reply.reply_case() != proto::StepReply::REPLY_NOT_SET),
                  "an answer or an error");
  } else {
    proto::Task task;
    if (task.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) evaluate(evaluator, task, pieces);
  }
  return 0;
}
