// The line of progress.
#include "cli/progress.h"

#include <gtest/gtest.h>

#include <string>

namespace evograsp::cli {
namespace {

// Short generations share a transaction, and are reported together when it is written.
TEST(Progress, TheRateIsThatOfTheRunHoweverManyReportsComeAtOnce) {
  std::FILE* out = std::tmpfile();
  ASSERT_NE(out, nullptr);
  Progress progress(ProgressStyle::kLines, 40, out);
  for (std::uint32_t generation = 0; generation < 40; ++generation)
    progress.show({generation, 0.5, 0.2, 3, (generation + 1) * 100ULL, (generation + 1) / 64.0});
  progress.finish();
  std::string text(static_cast<std::size_t>(std::ftell(out)), '\0');
  std::rewind(out);
  ASSERT_EQ(std::fread(text.data(), 1, text.size(), out), text.size());
  std::fclose(out);
  const auto last = text.find("generation 40/40");
  ASSERT_NE(last, std::string::npos) << text;
  EXPECT_NE(text.find("  6,400 trials/s", last), std::string::npos) << text;
}

}  // namespace
}  // namespace evograsp::cli
