#include <cmath>
#include <cstdint>

#include "common/random.h"
#include "sim/polytope6.h"
#include "sim/quality.h"

namespace evograsp::sim {
namespace {

// Points moved by up to `size` move epsilon by no more, and are in general position: no two facets share a
// plane.
template <class Point>
void shake(std::vector<Point>& points, double size) {
  std::uint64_t counter = 0;
  for (Point& p : points) {
    for (auto& x : p) {
      const auto bits = static_cast<std::int64_t>(mix64(++counter * 0x9e3779b97f4a7c15ULL));
      x += size * (static_cast<double>(bits) * 0x1.0p-63);
    }
  }
}

}  // namespace

struct Epsilon::Solver {
  Polytope6<double> fast;
  std::vector<Polytope6<double>::Point> points;
  std::unique_ptr<Polytope6<Quad>> careful;
  std::vector<Polytope6<Quad>::Point> wide;
  Wrench weakest{};
  bool gave_up = false;

  double answer();
  double careful_answer();
};

// The plain set first; where coplanar or repeated points break the surface, the set shaken by 1e-11, which
// costs at most 2.5e-11 of accuracy; where even that is too fine for 53 bits, the same in 113.
double Epsilon::Solver::answer() {
  using Outcome = Polytope6<double>::Outcome;
  Outcome outcome = fast.expand(points);
  if (outcome == Outcome::kGaveUp) {
    shake(points, 1e-11);
    outcome = fast.expand(points);
  }
  if (outcome == Outcome::kGaveUp) return careful_answer();
  gave_up = outcome == Outcome::kTooLarge;
  if (outcome != Outcome::kInside) return 0;
  weakest = fast.direction();
  return fast.radius();
}

double Epsilon::Solver::careful_answer() {
  if (!careful) careful = std::make_unique<Polytope6<Quad>>();
  wide.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int x = 0; x < 6; ++x) wide[i][x] = points[i][x];
  }
  const auto outcome = careful->expand(wide);
  gave_up = outcome == Polytope6<Quad>::Outcome::kTooLarge || outcome == Polytope6<Quad>::Outcome::kGaveUp;
  if (outcome != Polytope6<Quad>::Outcome::kInside) return 0;
  for (int x = 0; x < 6; ++x) weakest[x] = static_cast<double>(careful->direction()[x]);
  return static_cast<double>(careful->radius());
}

Epsilon::Epsilon() : solver_(std::make_unique<Solver>()) {}
Epsilon::~Epsilon() = default;
Epsilon::Epsilon(Epsilon&&) noexcept = default;
Epsilon& Epsilon::operator=(Epsilon&&) noexcept = default;

const Wrench& Epsilon::weakest() const {
  return solver_->weakest;
}

bool Epsilon::gave_up() const {
  return solver_->gave_up;
}

double Epsilon::operator()(std::span<const Wrench> wrenches) {
  solver_->gave_up = false;
  double largest = 0;
  for (const Wrench& w : wrenches) {
    for (double x : w) {
      if (!std::isfinite(x)) return 0;
      largest = std::fmax(largest, std::fabs(x));
    }
  }
  if (!(largest > 0)) return 0;
  // A power of two scales without rounding: longest wrench to between 1/8 and 1.
  int exponent = 0;
  std::frexp(largest, &exponent);
  const double down = std::ldexp(1.0, -(exponent + 2)), up = std::ldexp(1.0, exponent + 2);
  auto& points = solver_->points;
  points.assign(wrenches.begin(), wrenches.end());
  for (Wrench& w : points) {
    for (double& x : w) x *= down;
  }
  return solver_->answer() * up;
}

}  // namespace evograsp::sim
