// The whole program but main(): the tree of commands, and what a call of it comes to.
#pragma once

#include <memory>

#include "cli/cli.h"

namespace evograsp::cli {

// Every command, as help, completions and the manual see it. outcome must outlive the tree.
std::unique_ptr<CLI::App> make_app(Outcome& outcome);

// Parses, runs the command, and gives the exit code of docs/EXIT-CODES.md. Nothing is thrown.
int run(int argc, const char* const* argv);

}  // namespace evograsp::cli
