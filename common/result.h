// Values or errors. Functions that can fail on bad input return Result<T>; exceptions of libraries are
// caught where they are called. The process edge turns an Error into a message and an exit code.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace evograsp {

// What went wrong, in the terms of the exit-code table (docs/EXIT-CODES.md).
enum class ErrorCode {
  kUsage = 2,        // wrong flags or arguments
  kInvalid = 3,      // a file, frame or value is not acceptable
  kNotFound = 4,     // a file, run, champion or object is not there
  kIo = 5,           // reading or writing failed (disk full, permission)
  kUnavailable = 6,  // a peer does not answer or has refused
  kUnsupported = 7,  // understood, but not by this version
  kInternal = 70,    // a bug
};

struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string
      message;  // one line, starts with the file or peer concerned, says what to do next where it helps
};

template <class T>
using Result = tl::expected<T, Error>;
using Status = tl::expected<void, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace evograsp
