// A genome that killed or hung workers, run again under one's eyes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace evograsp::cli {

// Runs the trials of a poisoned genome of `run_folder` one by one in this process, through the evaluator that
// workers use. Each trial is announced before it runs, so that the last line names the one that kills or
// hangs. genome: which, when there are several. Gives the exit code.
int replay(const std::string& run_folder, std::optional<std::uint64_t> genome, bool json);

}  // namespace evograsp::cli
