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

  explicit DoublePole(const State& s) : motion_{{s[0], s[1]}, {s[2], s[4]}, {s[3], s[5]}} {}
  State state() const {
    const Motion& m = motion_;
    return {m.cart[0], m.cart[1], m.angle[0], m.rate[0], m.angle[1], m.rate[1]};
  }

  // 0.02 s of a constant force, in two integration steps of 0.01 s.
  void push(double force) {
    for (int k = 0; k < 2; ++k) integrate(force, 0.01);
  }
  bool fallen() const {
    constexpr double kTrack = 2.4, kAngle = 36 * det::kPi / 180;
    return !(std::fabs(motion_.cart[0]) <= kTrack && std::fabs(motion_.angle[0]) <= kAngle &&
             std::fabs(motion_.angle[1]) <= kAngle);
  }

 private:
  using Poles = double __attribute__((vector_size(16)));  // a number of each pole

  struct Motion {
    Poles cart;  // x, dx
    Poles angle, rate;
    Motion plus(const Motion& d, double h) const {
      return {cart + h * d.cart, angle + h * d.angle, rate + h * d.rate};
    }
  };

  // Taylor series, exact to the last bits up to 36 degrees.
  static Poles sine(Poles x) {
    const Poles z = x * x;
    Poles p = z / 6227020800 - 1.0 / 39916800;
    p = p * z + 1.0 / 362880;
    p = p * z - 1.0 / 5040;
    p = p * z + 1.0 / 120;
    p = p * z - 1.0 / 6;
    return x + x * z * p;
  }
  static Poles cosine(Poles x) {
    const Poles z = x * x;
    Poles p = 1.0 / 479001600 - z / 87178291200;
    p = p * z - 1.0 / 3628800;
    p = p * z + 1.0 / 40320;
    p = p * z - 1.0 / 720;
    p = p * z + 1.0 / 24;
    p = p * z - 0.5;
    return 1.0 + z * p;
  }

  static Motion slope(const Motion& m, double force) {
    constexpr double kGravity = -9.8, kCart = 1.0, kPoleFriction = 2e-6, kTrackFriction = 5e-4;
    // Masses of 0.1 and 0.01 kg on half lengths of 0.5 and 0.05 m.
    constexpr Poles kMass = {0.1, 0.01}, kMoment = {0.1 * 0.5, 0.01 * 0.05};
    constexpr Poles kTurn = {-0.75 / 0.5, -0.75 / 0.05};
    constexpr Poles kDrag = {kPoleFriction / (0.1 * 0.5), kPoleFriction / (0.01 * 0.05)};
    const Poles sin = sine(m.angle), cos = cosine(m.angle);
    const Poles torque = kDrag * m.rate + kGravity * sin;
    const Poles pull = kMoment * m.rate * m.rate * sin + 0.75 * kMass * cos * torque;
    const Poles mass = kMass * (1.0 - 0.75 * cos * cos);
    const double dx = m.cart[1];
    const double track = dx > 0 ? kTrackFriction : dx < 0 ? -kTrackFriction : 0.0;
    const double acceleration = (force - track + pull[0] + pull[1]) / (kCart + mass[0] + mass[1]);
    return {Poles{dx, acceleration}, m.rate, kTurn * (acceleration * cos + torque)};
  }
  void integrate(double force, double h) {
    const Motion a = slope(motion_, force), b = slope(motion_.plus(a, h / 2), force);
    const Motion c = slope(motion_.plus(b, h / 2), force), d = slope(motion_.plus(c, h), force);
    motion_ = motion_.plus(a, h / 6).plus(b, h / 3).plus(c, h / 3).plus(d, h / 6);
  }

  Motion motion_;
};

}  // namespace evograsp::bench
