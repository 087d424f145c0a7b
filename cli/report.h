// The process edge: errors become a message on stderr and an exit code.
#pragma once

#include <vector>

#include "common/config.h"
#include "common/result.h"

namespace evograsp::cli {

// Exit codes beside ErrorCode's (docs/EXIT-CODES.md).
inline constexpr int kExitOk = 0;
inline constexpr int kExitNo = 1;             // a question was answered with no: validate refused a file
inline constexpr int kExitInterrupted = 130;  // stopped by a signal; what was done is kept

// "evograsp: MESSAGE" on stderr; the exit code that goes with it.
int report(const Error& error);
// One line each, as a compiler says it: "FILE:LINE:COLUMN: MESSAGE".
int report(const std::vector<Diagnostic>& diagnostics);
// "evograsp: warning: MESSAGE" on stderr.
void warn(const std::string& message);

}  // namespace evograsp::cli
