// A run in Prometheus's text format: base units, counters end in _total, labels from fixed sets (never a
// genome or a worker: their number has no bound).
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/strangers.h"
#include "server/run_control.h"

namespace evograsp::server {

// Answers by class: index 2 counts 2xx, and so on.
using HttpCounts = std::array<std::uint64_t, 6>;

// Pure but for the process figures (/proc/self). Thread-safe.
std::string metrics_text(const RunSnapshot& snapshot, const HttpCounts& http,
                         const Strangers::Counts& refused);

}  // namespace evograsp::server
