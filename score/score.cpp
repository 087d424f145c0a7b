#include "score/score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace evograsp::score {
namespace {

constexpr std::string_view kCombinations[] = {"1", "12", "13", "14", "123", "124", "134", "1234"};

// Far beyond anything measured, and small enough for sums of squares over any population to stay finite.
// False for NaN.
bool within(double low, double x, double high) {
  return x >= low && x <= high;
}
constexpr double kFarthest = 1e100, kBestQuality = 1e6;

bool finite(const proto::Vec3& v) {
  return within(-kFarthest, v.x(), kFarthest) && within(-kFarthest, v.y(), kFarthest) &&
         within(-kFarthest, v.z(), kFarthest);
}

// A measurement comes from a worker, which may be broken or lie: one number must not end the run.
bool possible(const proto::Measurement& m) {
  return within(-kBestQuality, m.quality(), kBestQuality) && finite(m.p()) && finite(m.s()) &&
         finite(m.o()) && within(0, m.target_distance(), kFarthest) &&
         within(0, m.nearest_object(), kFarthest) && !std::isnan(m.theta());
}

double distance(const proto::Vec3& a, const proto::Vec3& b) {
  const double x = a.x() - b.x(), y = a.y() - b.y(), z = a.z() - b.z();
  return std::sqrt(x * x + y * y + z * z);
}

// f(0) = maximum, half of it at `range`, falling as 1/distance: beta / (d + alpha) written so that the
// maximum is plain to see.
constexpr double numerator(double maximum, double range) {
  return maximum * range;
}

}  // namespace

Result<Scorer> Scorer::create(const proto::FitnessConfig& c) {
  if (std::find(std::begin(kCombinations), std::end(kCombinations), c.terms()) == std::end(kCombinations))
    return fail(ErrorCode::kInvalid,
                "fitness.terms: '" + c.terms() + "' is not one of 1, 12, 13, 14, 123, 124, 134, 1234");
  Scorer s;
  s.normalised_ = c.preset() == proto::NORMALISED;
  s.gate_ = c.contact_gates_f3_f4();
  for (int t = 1; t <= 4; ++t)
    s.f_enabled_[t] = c.terms().find(static_cast<char>('0' + t)) != std::string::npos;
  const auto pick = [](bool given, double value, double preset) { return given ? value : preset; };
  const bool n = s.normalised_;
  s.alpha_ = pick(c.has_alpha(), c.alpha(), n ? 0.03 : 0.1);
  s.epsilon_ = pick(c.has_epsilon(), c.epsilon(), n ? 0.02 : 0.1);
  s.k_ = pick(c.has_k(), c.k(), n ? 0.1 : 1000);
  s.beta_ = pick(c.has_beta(), c.beta(), n ? numerator(0.1, s.alpha_) : 100);
  s.lambda_ = pick(c.has_lambda(), c.lambda(), n ? numerator(0.1, s.epsilon_) : 100);
  s.gamma_ = pick(c.has_gamma(), c.gamma(), n ? 0.6 / c.quality_reference() : 10000);
  s.f1_cap_ = n ? s.gamma_ * c.quality_reference() : std::numeric_limits<double>::infinity();
  s.omega_ = pick(c.has_omega(), c.omega(), n ? 0.2 : 1000);
  s.w_ = pick(c.has_w(), c.w(), n ? 0.1 : 500);
  s.theta_min_ = c.theta_min();
  s.theta_max_ = c.theta_max();
  s.near_target_ = c.near_target();
  s.hold_weight_ = c.hold_weight();
  s.hold_range_ = c.hold_range();
  return s;
}

Terms Scorer::trial(const proto::Measurement& m) const {
  Terms t;
  if (m.outcome() == proto::NOT_A_NUMBER || m.outcome() == proto::NO_TRIAL || !possible(m)) return t;
  if (!(m.quality() > 0) || m.nearest_object() < m.target_distance()) {
    t.f2 = beta_ / (distance(m.p(), m.o()) + alpha_);
  } else {
    t.f1 = std::min(gamma_ * m.quality(), f1_cap_);
    t.f2 = k_;
    t.hold = std::max(0.0, 1 - m.target_distance() / hold_range_);
  }
  if (!gate_ || m.contacts() > 0) {
    t.f3 = lambda_ / (distance(m.p(), m.s()) + epsilon_);
    if (m.theta() >= theta_min_ && m.theta() <= theta_max_)
      t.f4 = m.target_distance() < near_target_ ? omega_ : w_;
  }
  const double f[5] = {0, t.f1, t.f2, t.f3, t.f4};
  for (int i = 1; i <= 4; ++i)
    if (f_enabled_[i]) t.total += f[i];
  t.total *= 1 - hold_weight_ * (1 - t.hold);
  return std::isfinite(t.total) ? t : Terms{};
}

double Scorer::evaluation(std::span<const proto::Measurement> trials) const {
  if (trials.empty()) return 0;
  double sum = 0;
  for (const proto::Measurement& m : trials) sum += trial(m).total;
  return sum / static_cast<double>(trials.size());
}

bool held(const proto::Measurement& m) {
  return m.held();
}

bool success(const proto::Measurement& m) {
  return m.outcome() == proto::GRASPED && m.quality() > 0;
}

}  // namespace evograsp::score
