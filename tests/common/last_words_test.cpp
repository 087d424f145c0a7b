// What goes past everybody ends the program with a line and an exit code, on any thread, and not with a
// signal.
#include "common/last_words.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace evograsp {
namespace {

template <class Thrown>
[[noreturn]] void throw_on_a_thread(Thrown thrown) {
  set_last_words("program");
  std::thread([thrown] { throw thrown; }).join();
  std::exit(0);
}

using ::testing::ExitedWithCode;

TEST(LastWordsDeathTest, WantOfMemoryOrThreadsIsNoBug) {
  EXPECT_EXIT(throw_on_a_thread(std::bad_alloc()), ExitedWithCode(5), "^program: not enough memory.*\n$");
  EXPECT_EXIT(throw_on_a_thread(std::system_error(EAGAIN, std::generic_category())), ExitedWithCode(5),
              "^program: the system refused: Resource temporarily unavailable\n$");
}

TEST(LastWordsDeathTest, AllElseIsABugWithItsMessage) {
  EXPECT_EXIT(throw_on_a_thread(std::logic_error("two champions")), ExitedWithCode(70),
              "^program: a bug, please report it: two champions\n$");
  EXPECT_EXIT(throw_on_a_thread(7), ExitedWithCode(70), "^program: a bug.*unknown exception\n$");
  EXPECT_EXIT((set_last_words("program"), std::terminate()), ExitedWithCode(70), "^program: a bug");
}

TEST(LastWords, WhatIsCaughtHasTheSameCodes) {
  EXPECT_EQ(error_of_exception(std::bad_alloc()).code, ErrorCode::kIo);
  EXPECT_EQ(error_of_exception(std::system_error(EMFILE, std::generic_category())).code, ErrorCode::kIo);
  EXPECT_EQ(error_of_exception(std::out_of_range("7")).code, ErrorCode::kInternal);
}

}  // namespace
}  // namespace evograsp
