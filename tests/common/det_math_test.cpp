#include "common/det_math.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/random.h"

namespace evograsp {
namespace {

// Distance in units in the last place of the (80-bit) reference, rounded to double precision spacing.
double ulps(double got, long double want) {
  const double rounded = static_cast<double>(want);
  const double spacing =
      std::nextafter(std::fabs(rounded), std::numeric_limits<double>::infinity()) - std::fabs(rounded);
  return static_cast<double>(std::fabs(static_cast<long double>(got) - want) / spacing);
}

template <class Ours, class Reference>
double worst_ulps(double low, double high, Ours ours, Reference reference) {
  Random random(17, Purpose::kTestHarness);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = random.uniform(low, high);
    worst = std::max(worst, ulps(ours(x), reference(static_cast<long double>(x))));
  }
  return worst;
}

TEST(DetMath, SineAndCosineFollowTheLongDoubleReference) {
  EXPECT_LT(worst_ulps(-10, 10, det::sin, [](long double x) { return std::sin(x); }), 1.5);
  EXPECT_LT(worst_ulps(-10, 10, det::cos, [](long double x) { return std::cos(x); }), 1.5);
}

TEST(DetMath, ExponentialAndLogarithmFollowTheReference) {
  EXPECT_LT(worst_ulps(-700, 700, det::exp, [](long double x) { return std::exp(x); }), 1.5);
  EXPECT_LT(worst_ulps(1e-6, 100, det::log, [](long double x) { return std::log(x); }), 1.5);
}

TEST(DetMath, InverseFunctionsFollowTheReference) {
  EXPECT_LT(worst_ulps(-50, 50, det::atan, [](long double x) { return std::atan(x); }), 1.5);
  Random random(18, Purpose::kTestHarness);
  for (int i = 0; i < 100000; ++i) {
    const double y = random.uniform(-2, 2);
    const double x = random.uniform(-2, 2);
    ASSERT_NEAR(det::atan2(y, x), std::atan2(y, x), 1e-15) << y << " " << x;
    const double c = random.uniform(-1, 1);
    ASSERT_NEAR(det::acos(c), std::acos(c), 2e-15) << c;
    ASSERT_NEAR(det::asin(c), std::asin(c), 2e-15) << c;
  }
}

TEST(DetMath, HyperbolicTangentFollowsTheReference) {
  EXPECT_LT(worst_ulps(-1, 1, det::tanh, [](long double x) { return std::tanh(x); }), 5.5);
  EXPECT_LT(worst_ulps(-25, 25, det::tanh, [](long double x) { return std::tanh(x); }), 5.5);
}

TEST(DetMath, EdgesAreDefined) {
  EXPECT_EQ(det::acos(1.0 + 1e-12), 0.0);
  EXPECT_EQ(det::acos(-1.5), det::kPi);
  EXPECT_TRUE(std::isnan(det::sin(1e9)));
  EXPECT_TRUE(std::isnan(det::sin(std::numeric_limits<double>::infinity())));
  EXPECT_EQ(det::exp(-1000), 0.0);
  EXPECT_TRUE(std::isinf(det::exp(1000)));
  EXPECT_TRUE(std::isinf(det::log(0)));
  EXPECT_TRUE(std::isnan(det::log(-1)));
  EXPECT_EQ(det::tanh(100), 1.0);
  EXPECT_EQ(det::atan2(0.0, -1.0), det::kPi);
  EXPECT_EQ(det::atan2(-0.0, -1.0), -det::kPi);
}

}  // namespace
}  // namespace evograsp
