// Closing against brute force: the same rules, followed in steps of 0.05 degrees.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "sim/closing.h"
#include "tests/sim/attempt_parts.h"

namespace evograsp::sim {
namespace {

using testing::AttemptParts;
using testing::make_simulator;
using testing::random_trial;

constexpr double kDegree = det::kPi / 180;

int scaled(int n) {
  const char* factor = std::getenv("EVOGRASP_TEST_SCALE");
  return factor != nullptr ? n * std::max(1, std::atoi(factor)) : n;
}

// Small steps of one motor: a part that comes within the tolerance while getting nearer stops its joints
// where they stood before the step.
class BruteForce {
 public:
  BruteForce(AttemptParts& parts, double step) : parts_(parts), step_(step) {}

  void close() {
    for (const HandMotor& motor : parts_.hand.motors()) close(motor);
  }

 private:
  void pose() { parts_.state.pose(parts_.hand, parts_.state.link[0]); }

  double least(const HandMotor& motor, int part) const {
    const auto p = static_cast<std::size_t>(part);
    const Shape& shape = parts_.hand.parts()[p].shape;
    const Pose& pose = parts_.state.part[p];
    const Aabb box = bounds(shape, pose);
    double least = 1;
    for (const Obstacle& o : parts_.posed.obstacle)
      if (box.overlaps(o.box, 0.01)) least = std::min(least, distance(shape, pose, o).distance);
    for (std::size_t q = 0; q < parts_.hand.parts().size(); ++q) {
      const HandPart& other = parts_.hand.parts()[q];
      if ((parts_.hand.ancestors(other.link) & motor.joints) ||
          !parts_.hand.may_collide(part, static_cast<int>(q)))
        continue;
      if ((parts_.state.part[q] * other.shape.centre - pose * shape.centre).norm() >
          other.shape.radius + shape.radius + 0.01)
        continue;
      least = std::min(least, distance(shape, pose, other.shape, parts_.state.part[q]).distance);
    }
    return least;
  }

  void close(const HandMotor& motor) {
    JointSet active = motor.joints;
    std::vector<double> before(parts_.hand.parts().size());
    for (int p : motor.part) before[static_cast<std::size_t>(p)] = least(motor, p);
    while (active != 0) {
      const std::vector<double> old = parts_.state.value;
      for (;;) {  // the step, repeated with fewer joints until nothing is in the way
        parts_.state.value = old;
        JointSet limited = 0;
        for (int j : motor.joint) {
          if (!(active >> j & 1)) continue;
          const HandJoint& joint = parts_.hand.joints()[static_cast<std::size_t>(j)];
          double& q = parts_.state.value[static_cast<std::size_t>(j)];
          q = std::clamp(q + step_ * parts_.hand.ratio(j), joint.lower, joint.upper);
          if (q == (parts_.hand.ratio(j) > 0 ? joint.upper : joint.lower)) limited |= JointSet{1} << j;
        }
        pose();
        JointSet touched = 0;
        std::vector<double> now = before;
        for (int p : motor.part) {
          const JointSet above =
              parts_.hand.ancestors(parts_.hand.parts()[static_cast<std::size_t>(p)].link) & active;
          if (above == 0) continue;
          double& d = now[static_cast<std::size_t>(p)];
          d = least(motor, p);
          if (d <= parts_.tolerance && d < before[static_cast<std::size_t>(p)]) touched |= above;
        }
        if (touched == 0) {
          before = now;
          active &= ~limited;
          break;
        }
        active &= ~touched;
        if (active == 0) {
          parts_.state.value = old;
          pose();
          break;
        }
      }
    }
  }

  AttemptParts& parts_;
  double step_;
};

struct Errors {
  std::vector<double> joint;  // of each joint that something stopped, degrees
  int trials = 0;
  double at(double quantile) {
    std::sort(joint.begin(), joint.end());
    return joint[static_cast<std::size_t>(quantile * static_cast<double>(joint.size() - 1))];
  }
};

Errors compare(const std::vector<std::string>& objects, const std::string& hand, int trials, double step) {
  const auto sim = make_simulator(objects, hand);
  AttemptParts fast(*sim), slow(*sim);
  Errors errors;
  for (int i = 0; errors.trials < trials; ++i) {
    const testing::Trial trial = random_trial(*sim, static_cast<std::uint64_t>(i));
    if (!fast.approach_only(trial)) continue;
    slow.approach_only(trial);
    fast.closing.close(fast.hand, fast.posed, fast.tolerance, fast.state);
    BruteForce(slow, step).close();
    ++errors.trials;
    for (const HandMotor& motor : fast.hand.motors()) {
      for (const int j : motor.joint) {
        const HandJoint& joint = fast.hand.joints()[static_cast<std::size_t>(j)];
        const double limit = fast.hand.ratio(j) > 0 ? joint.upper : joint.lower;
        const double a = fast.state.value[static_cast<std::size_t>(j)],
                     b = slow.state.value[static_cast<std::size_t>(j)];
        if (a != limit || b != limit) errors.joint.push_back(std::fabs(a - b) / kDegree);
      }
    }
  }
  return errors;
}

class ClosingAgainstBruteForce : public ::testing::TestWithParam<std::string> {};

TEST_P(ClosingAgainstBruteForce, JointsStopWithinATenthOfADegree) {
  Errors errors = compare({GetParam()}, "meka_h2", scaled(40), 0.05 * kDegree);
  std::printf("%s: median %.4f, p95 %.4f, worst %.3f degrees\n", GetParam().c_str(), errors.at(0.5),
              errors.at(0.95), errors.at(1));
  EXPECT_LT(errors.at(0.95), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Objects, ClosingAgainstBruteForce,
                         ::testing::Values("cylinder", "cube", "sphere", "mug", "plated_mug"),
                         [](const auto& named) { return named.param; });

TEST(Closing, OtherHandsStopWhereBruteForceStops) {
  Errors barrett = compare({"cube"}, "barrett", scaled(30), 0.05 * kDegree);
  std::printf("barrett: median %.4f, p95 %.4f, worst %.3f degrees\n", barrett.at(0.5), barrett.at(0.95),
              barrett.at(1));
  EXPECT_LT(barrett.at(0.95), 0.1);
  // A prismatic joint's 0.1 "degrees" are 1.7 mm; steps of 0.05 mm hold it to 0.1 mm.
  Errors jaw = compare({"cube"}, "parallel_jaw", scaled(30), 5e-5);
  std::printf("jaw: p95 %.5f mm\n", jaw.at(0.95) * kDegree * 1e3);
  EXPECT_LT(jaw.at(0.95) * kDegree, 3e-4);
}

struct SceneCase {
  const char* name;
  std::vector<std::string> objects;
  const char* hand = "meka_h2";
  double size_jitter = 0;
};

class NoPenetration : public ::testing::TestWithParam<SceneCase> {};

// 2,000 trials in each scene.
TEST_P(NoPenetration, NoLinkEndsDeeperThanTheTolerance) {
  const SceneCase& scene = GetParam();
  proto::Config config;
  config.mutable_scene()->set_size_jitter(scene.size_jitter);
  const auto sim = make_simulator(scene.objects, scene.hand, config);
  AttemptParts parts(*sim);
  const int trials = scaled(2000);
  double least = 1, least_self = 1;
  int closed = 0, touched_itself = 0;
  for (int i = 0; i < trials; ++i) {
    if (!parts.approach_only(random_trial(*sim, static_cast<std::uint64_t>(i)))) continue;
    const double stood = parts.self_clearance();
    parts.closing.close(parts.hand, parts.posed, parts.tolerance, parts.state);
    const double ended = parts.self_clearance();
    least = std::min(least, parts.clearance());
    least_self = std::min(least_self, std::min(ended, stood));
    ASSERT_GT(least, -1e-7) << "trial " << i;
    ASSERT_GT(least_self, -1e-7) << "trial " << i;
    ++closed;
    touched_itself += ended <= parts.tolerance && ended < stood ? 1 : 0;
  }
  EXPECT_GT(closed, trials / 3);
  EXPECT_GT(touched_itself, 0) << "no finger met another: the second law was not tried";
  std::printf(
      "%s: least gap %.4f mm to things, %.4f mm to itself, %d of %d trials closed, %d on the hand itself\n",
      scene.name, least * 1e3, least_self * 1e3, closed, trials, touched_itself);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NoPenetration,
                         ::testing::Values(SceneCase{"cylinder", {"cylinder"}},
                                           SceneCase{"cube_5cm", {"cube_5cm"}},
                                           SceneCase{"sphere_3cm", {"sphere_3cm"}}, SceneCase{"mug", {"mug"}},
                                           SceneCase{"all", {"cylinder", "cube", "sphere", "mug"}},
                                           SceneCase{"meshes", {"cup", "bottle"}},
                                           SceneCase{"any_size", {"mug", "cube", "bottle"}, "meka_h2", 0.3},
                                           SceneCase{"barrett", {"cube", "mug"}, "barrett"},
                                           SceneCase{"barrett_any_size", {"cup", "sphere"}, "barrett", 0.3},
                                           SceneCase{"jaw", {"cube_5cm", "cup"}, "parallel_jaw"}),
                         [](const auto& named) { return std::string(named.param.name); });

}  // namespace
}  // namespace evograsp::sim
