#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

#include "common/det_math.h"
#include "common/random.h"

namespace evograsp {
namespace {

// One digest of a million results: any compiler, optimisation level or processor that rounds differently
// changes it.
TEST(DetMathDeterminism, EveryMachineGivesTheseBits) {
  Random random(1, Purpose::kTestHarness);
  std::uint64_t digest = 0;
  const auto add = [&digest](double v) { digest = mix64(digest ^ std::bit_cast<std::uint64_t>(v)); };
  for (int i = 0; i < 100000; ++i) {
    const double a = random.uniform(-8, 8);
    const double b = random.uniform(-1, 1);
    add(det::sin(a));
    add(det::cos(a));
    add(det::exp(a));
    add(det::log(a * a + 1e-9));
    add(det::tanh(a));
    add(det::atan(a));
    add(det::atan2(a, b));
    add(det::acos(b));
    add(det::asin(b));
  }
  EXPECT_EQ(digest, 15091655509340777159ULL);
}

}  // namespace
}  // namespace evograsp
