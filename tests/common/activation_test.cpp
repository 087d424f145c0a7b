#include "common/activation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace evograsp {
namespace {

template <class Exact>
double largest_error(Activation f, double low, double high, Exact exact) {
  double worst = 0;
  constexpr int kSteps = 200'000;
  for (int k = 0; k <= kSteps; ++k) {
    const auto x = static_cast<float>(low + (high - low) * k / kSteps);
    const auto y = static_cast<double>(activation::apply<float>(f, x));
    worst = std::max(worst, std::fabs(y - exact(static_cast<double>(x))));
  }
  return worst;
}

TEST(Activation, ErrorsStayBelowWhatIsPromised) {
  EXPECT_LT(largest_error(Activation::kTanh, -20, 20, [](double x) { return std::tanh(x); }), 3e-7);
  EXPECT_LT(largest_error(Activation::kSteepSigmoid, -10, 10,
                          [](double x) { return 1 / (1 + std::exp(-4.9 * x)); }),
            3e-7);
  EXPECT_LT(largest_error(Activation::kGaussian, -10, 10, [](double x) { return std::exp(-x * x); }), 2e-6);
  EXPECT_LT(largest_error(Activation::kSine, -100, 100, [](double x) { return std::sin(x); }), 1e-6);
  EXPECT_EQ(largest_error(Activation::kAbs, -9, 9, [](double x) { return std::fabs(x); }), 0);
  EXPECT_EQ(largest_error(Activation::kRelu, -9, 9, [](double x) { return std::max(x, 0.0); }), 0);
  EXPECT_EQ(largest_error(Activation::kLinear, -9, 9, [](double x) { return x; }), 0);
  EXPECT_EQ(largest_error(Activation::kStep, -9, 9, [](double x) { return x > 0 ? 1.0 : 0.0; }), 0);
}

TEST(Activation, OddAndEvenFunctionsAreSoToTheBit) {
  for (int k = 0; k < 20'000; ++k) {
    const float x = static_cast<float>(k) * 0.0013f;
    for (const Activation odd : {Activation::kTanh, Activation::kSine, Activation::kLinear})
      EXPECT_EQ(activation::apply<float>(odd, -x), -activation::apply<float>(odd, x));
    for (const Activation even : {Activation::kGaussian, Activation::kAbs})
      EXPECT_EQ(activation::apply<float>(even, -x), activation::apply<float>(even, x));
  }
}

TEST(Activation, SquashingFunctionsStayInRangeAndFallByRoundingOnly) {
  float last_tanh = -2, last_sigmoid = -1;
  for (int k = -40'000; k <= 40'000; ++k) {
    const float x = static_cast<float>(k) * 0.00025f;
    const float t = activation::apply<float>(Activation::kTanh, x),
                s = activation::apply<float>(Activation::kSteepSigmoid, x);
    EXPECT_TRUE(t >= -1 && t <= 1 && s >= 0 && s <= 1) << x;
    EXPECT_GE(t, last_tanh - 6e-7f);
    EXPECT_GE(s, last_sigmoid - 6e-7f);
    last_tanh = t, last_sigmoid = s;
  }
}

TEST(Activation, EveryFiniteArgumentGivesAFiniteValue) {
  for (int f = 0; f < kActivations; ++f)
    for (const float x : {0.0f, -0.0f, 1e-45f, -1e-38f, 1e30f, -1e30f, 3.4e38f, -3.4e38f})
      EXPECT_LE(std::fabs(activation::apply<float>(static_cast<Activation>(f), x)), kLargestValue)
          << f << " of " << x;
}

}  // namespace
}  // namespace evograsp
