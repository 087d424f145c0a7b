#include "common/last_words.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <system_error>

namespace evograsp {
namespace {

const char* program_name = "evograsp";
std::atomic<bool> spoken{false};

// There may be no memory left for more than this.
[[noreturn]] void leave(ErrorCode code, const char* message, const char* detail = "") {
  if (spoken.exchange(true))
    for (;;) ::pause();  // another thread is leaving
  std::array<char, 512> line{};
  const int size = std::snprintf(line.data(), line.size() - 1, "%s: %s%s", program_name, message, detail);
  const std::size_t end = std::min(static_cast<std::size_t>(std::max(size, 0)), line.size() - 2);
  line[end] = '\n';
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), end + 1);
  ::_exit(static_cast<int>(code));
}

[[noreturn]] void last_words() {
  const std::exception_ptr error = std::current_exception();
  if (!error) leave(ErrorCode::kInternal, "a bug, please report it: ended without an error");
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    leave(ErrorCode::kIo, "not enough memory on this machine");
  } catch (const std::system_error& e) {
    leave(ErrorCode::kIo, "the system refused: ", e.what());
  } catch (const std::exception& e) {
    leave(ErrorCode::kInternal, "a bug, please report it: ", e.what());
  } catch (...) {
    leave(ErrorCode::kInternal, "a bug, please report it: an unknown exception");
  }
}

}  // namespace

Error error_of_exception(const std::exception& caught) {
  if (dynamic_cast<const std::bad_alloc*>(&caught) != nullptr)
    return {ErrorCode::kIo, "not enough memory on this machine"};
  if (dynamic_cast<const std::system_error*>(&caught) != nullptr)
    return {ErrorCode::kIo, std::string("the system refused: ") + caught.what()};
  return {ErrorCode::kInternal, std::string("a bug, please report it: ") + caught.what()};
}

void set_last_words(const char* program) {
  program_name = program;
  std::set_terminate(last_words);
}

}  // namespace evograsp
