// What a program says when an error has gone past everybody.
#pragma once

#include <exception>

#include "common/result.h"

namespace evograsp {

// What was caught, for its catcher to report: kIo for want of memory, threads or descriptors, kInternal for
// all else.
Error error_of_exception(const std::exception& caught);

// For main(), before anything else. An exception that nobody catches, on whatever thread, then ends the
// program with one line on standard error, "PROGRAM: MESSAGE", and an exit code of docs/EXIT-CODES.md instead
// of a signal: 5 for want of memory, threads or descriptors, 70 for a bug.
//
// program: its name; must live as long as the program.
void set_last_words(const char* program);

}  // namespace evograsp
