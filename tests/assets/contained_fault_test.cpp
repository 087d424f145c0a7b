// Work in a process of its own, with limits.
#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>

#include "assets/contained.h"

namespace evograsp::assets {
namespace {

TEST(Contained, CrashesHangsAndGreedBecomeErrors) {
  Containment limits;
  limits.seconds = 1;
  limits.memory = std::size_t{256} << 20;
  limits.answer = 1 << 20;
  const auto run = [&](const auto& work) {
    return run_contained([&]() -> Result<std::string> { return work(); }, limits);
  };
  EXPECT_EQ(run([] { return std::string("fine"); }).value(), "fine");
  const auto crash = run([] {
    std::raise(SIGSEGV);
    return std::string();
  });
  ASSERT_FALSE(crash);
  EXPECT_NE(crash.error().message.find("signal 11"), std::string::npos) << crash.error().message;
  const auto hang = run([] {
    volatile unsigned spin = 0;
    while (true) spin = spin + 1;
    return std::string();
  });
  ASSERT_FALSE(hang);
  EXPECT_NE(hang.error().message.find("longer than 1 s"), std::string::npos) << hang.error().message;
  const auto thrown = run([]() -> std::string { throw std::runtime_error("no good"); });
  ASSERT_FALSE(thrown);
  EXPECT_EQ(thrown.error().message, "no good");
  EXPECT_FALSE(run([] { return std::string(2 << 20, 'x'); })) << "answer too long";
}

}  // namespace
}  // namespace evograsp::assets
