// Two poles of different length on one cart (Wieland 1991), integrated by the classical Runge-Kutta method:
// the standard test of neuroevolution. Metres, kilograms, seconds, radians.
#pragma once

#include <array>
#include <cmath>

#include "common/det_math.h"

namespace evograsp::bench {

class DoublePole {
 public:
  // x, dx, theta1, dtheta1 (long pole), theta2, dtheta2 (short pole)
  using State = std::array<double, 6>;

  explicit DoublePole(const State& start) : state_(start) {}
  const State& state() const { return state_; }

  // 0.02 s of a constant force, in two integration steps of 0.01 s.
  void push(double force) {
    for (int k = 0; k < 2; ++k) integrate(force, 0.01);
  }
  bool fallen() const {
    constexpr double kTrack = 2.4, kAngle = 36 * det::kPi / 180;
    return !(std::fabs(state_[0]) <= kTrack && std::fabs(state_[2]) <= kAngle &&
             std::fabs(state_[4]) <= kAngle);
  }

 private:
  static State slope(const State& s, double force) {
    constexpr double kGravity = -9.8, kCart = 1.0, kPoleFriction = 2e-6, kTrackFriction = 5e-4;
    constexpr double kHalfLength[] = {0.5, 0.05}, kMass[] = {0.1, 0.01};
    double pull = 0, mass = 0, sine[2], cosine[2], friction[2];
    for (int i = 0; i < 2; ++i) {
      const double rate = s[3 + 2 * i], moment = kMass[i] * kHalfLength[i];
      det::sincos(s[2 + 2 * i], &sine[i], &cosine[i]);
      friction[i] = kPoleFriction * rate / moment;
      pull +=
          moment * rate * rate * sine[i] + 0.75 * kMass[i] * cosine[i] * (friction[i] + kGravity * sine[i]);
      mass += kMass[i] * (1 - 0.75 * cosine[i] * cosine[i]);
    }
    const double track = s[1] > 0 ? kTrackFriction : s[1] < 0 ? -kTrackFriction : 0.0;
    const double acceleration = (force - track + pull) / (kCart + mass);
    State d = {s[1], acceleration, s[3], 0, s[5], 0};
    for (int i = 0; i < 2; ++i)
      d[3 + 2 * i] = -0.75 / kHalfLength[i] * (acceleration * cosine[i] + kGravity * sine[i] + friction[i]);
    return d;
  }
  static State plus(const State& s, const State& d, double h) {
    State r;
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = s[i] + h * d[i];
    return r;
  }
  void integrate(double force, double h) {
    const State a = slope(state_, force), b = slope(plus(state_, a, h / 2), force);
    const State c = slope(plus(state_, b, h / 2), force), d = slope(plus(state_, c, h), force);
    for (std::size_t i = 0; i < state_.size(); ++i) state_[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }

  State state_;
};

}  // namespace evograsp::bench
