// The three commands as messages: cmd_shuffle, cmd_get_info, cmd_get_quality.
#pragma once

#include "proto/wire.pb.h"
#include "sim/simulator.h"

namespace evograsp::worker {

// Answers one command with what the library itself gives. The request names the scene (seed) and the target
// it is about; get_info and get_quality without a shuffle before are an error. Never throws.
void answer_step(const sim::Simulator& simulator, sim::Workspace& workspace,
                 const proto::StepRequest& request, proto::StepReply& reply);

}  // namespace evograsp::worker
