// `evograsp bench`: what this machine can do.
#pragma once

#include "cli/cli.h"

namespace evograsp::cli {

void add_bench(CLI::App& app, Outcome& outcome);

}  // namespace evograsp::cli
