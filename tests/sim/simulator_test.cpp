// The simulator's door: every pose has a defined outcome and every measurement its meaning.
#include "sim/simulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

using testing::make_simulator;

class SimulatorTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { sim_ = make_simulator({"cube"}); }
  static void TearDownTestSuite() { sim_.reset(); }

  // A cube of 6 cm in the middle of the table.
  static Placements centred() {
    Placements p;
    p.seed = 1;
    p.pose = {Pose{Mat3::Identity(), Vec3(0, 0, 0.03)}};
    p.resting = {0};
    p.present = {1};
    return p;
  }
  // Palm down, fingers along -x.
  static Pose above(const Vec3& tool_point) {
    Pose tool;
    tool.rotation.col(0) = Vec3(-1, 0, 0);
    tool.rotation.col(1) = Vec3(0, 1, 0);
    tool.rotation.col(2) = Vec3(0, 0, -1);
    tool.position = tool_point;
    return tool;
  }
  static Measurement run(const Pose& tool, GraspReport* report = nullptr) {
    const auto workspace = sim_->make_workspace();
    return sim_->get_quality(centred(), 0, tool, *workspace, report);
  }

  static std::shared_ptr<const Simulator> sim_;
};

std::shared_ptr<const Simulator> SimulatorTest::sim_;

TEST_F(SimulatorTest, AHandInFreeAirArrivesAndMisses) {
  GraspReport report;
  const Pose tool = above({0.2, 0.2, 0.4});
  const Measurement m = run(tool, &report);
  EXPECT_EQ(m.outcome, proto::MISSED);
  EXPECT_LT((m.p - tool.position).norm(), 1e-12);
  EXPECT_LT((m.s - tool.position).norm(), 1e-12) << "nothing stopped it";
  EXPECT_EQ(m.contacts, 0);
  EXPECT_EQ(m.obstructions, 0);
  EXPECT_EQ(m.quality, 0);
  EXPECT_LT((m.o - Vec3(0, 0, 0.03)).norm(), 1e-9);
  EXPECT_NEAR(m.target_distance, (m.o - m.s).norm(), 1e-12);
  EXPECT_EQ(m.nearest_object, m.target_distance) << "one object is the nearest";
}

TEST_F(SimulatorTest, ClosingOnNothingReachesEveryLimitThatNothingBlocks) {
  GraspReport report;
  run(above({0.2, 0.2, 0.4}), &report);
  int at_limit = 0;
  for (int j = 0; j < sim_->hand().joint_size(); ++j) {
    const double q = report.joints[static_cast<std::size_t>(j)];
    EXPECT_GE(q, sim_->hand().joint(j).lower());
    EXPECT_LE(q, sim_->hand().joint(j).upper());
    at_limit += q == sim_->hand().joint(j).upper();
  }
  EXPECT_GE(at_limit, 9) << "three fingers of three joints curl freely";
  for (const auto& motor : sim_->hand().motor()) {
    if (!motor.hold()) continue;
    for (const unsigned j : motor.joint()) {
      EXPECT_EQ(report.joints[j], sim_->hand().preset(static_cast<int>(j)))
          << motor.name() << " holds its preset";
    }
  }
}

TEST_F(SimulatorTest, APoseInsideTheObjectStopsAtFirstTouchAbove) {
  const Measurement m = run(above({0, 0, 0.0}));
  EXPECT_NE(m.outcome, proto::BLOCKED);
  EXPECT_GT(m.s.z(), m.p.z() + 0.01) << "the palm or a finger met the cube on the way";
  EXPECT_NEAR(m.s.x(), m.p.x(), 1e-12);
  EXPECT_NEAR(m.s.y(), m.p.y(), 1e-12);
}

TEST_F(SimulatorTest, AStartInsideTheTableIsBlockedAndMeasuredAtItsStart) {
  Pose tool = above({0.2, 0.2, sim_->hand().standoff() - 0.02});
  tool.rotation.col(1) = Vec3(0, -1, 0);
  tool.rotation.col(2) = Vec3(0, 0, 1);  // comes from below, out of the table top
  const Measurement m = run(tool);
  EXPECT_EQ(m.outcome, proto::BLOCKED);
  EXPECT_LT((m.s - Vec3(tool.position - sim_->hand().standoff() * Vec3::UnitZ())).norm(), 1e-9);
  EXPECT_EQ(m.quality, 0);
  EXPECT_EQ(m.contacts, 0);
  EXPECT_TRUE(std::isfinite(m.theta));
}

TEST_F(SimulatorTest, BeyondTheWristsReachIsUnreachable) {
  EXPECT_EQ(run(above({5, 0, 0.1})).outcome, proto::UNREACHABLE);
  EXPECT_EQ(run(above({1e8, 0, 0.1})).outcome, proto::UNREACHABLE);
}

TEST_F(SimulatorTest, NumbersThatAreNoneAreAnOutcomeNotACrash) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1e300, -1e308}) {
    for (int i = 0; i < 3; ++i) {
      Pose tool = above({0, 0, 0.1});
      tool.position[i] = bad;
      const Measurement m = run(tool);
      EXPECT_EQ(m.outcome, proto::NOT_A_NUMBER) << bad;
      EXPECT_EQ(m.quality, 0);
      EXPECT_TRUE(is_finite(m.p) && is_finite(m.s) && is_finite(m.o));
      EXPECT_TRUE(std::isfinite(m.theta) && std::isfinite(m.target_distance) &&
                  std::isfinite(m.nearest_object));
    }
  }
  Pose tool = above({0, 0, 0.1});
  tool.rotation(1, 1) = nan;
  EXPECT_EQ(run(tool).outcome, proto::NOT_A_NUMBER);
}

TEST_F(SimulatorTest, ATargetThatIsNotThereIsAMiss) {
  const auto workspace = sim_->make_workspace();
  for (const int target : {-1, 1, 1000}) {
    const Measurement m = sim_->get_quality(centred(), target, above({0, 0, 0.1}), *workspace);
    EXPECT_EQ(m.outcome, proto::MISSED);
    EXPECT_EQ(m.quality, 0);
  }
}

TEST_F(SimulatorTest, ContactsLieOnTheTargetInCanonicalOrder) {
  const auto workspace = sim_->make_workspace();
  int seen = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const testing::Trial t = testing::random_trial(*sim_, i);
    GraspReport report;
    const Measurement m = sim_->get_quality(t.placements, 0, t.tool, *workspace, &report);
    ASSERT_EQ(static_cast<int>(report.contacts.size()), m.contacts);
    EXPECT_EQ(m.outcome == proto::GRASPED, m.contacts > 0) << "trial " << i;
    for (std::size_t k = 0; k < report.contacts.size(); ++k) {
      const Contact& c = report.contacts[k];
      const Vec3 p = t.placements.pose[0].inverse() * c.point;
      EXPECT_NEAR(p.cwiseAbs().maxCoeff(), 0.03, 4e-4)
          << "on a face of the cube (or its rounded edge), trial " << i;
      EXPECT_NEAR(c.normal.norm(), 1, 1e-9);
      EXPECT_LT(c.normal.dot(c.point - m.o), 0) << "normals point into the target";
      EXPECT_GE(c.gap, -1e-7);
      EXPECT_LE(c.gap, sim_->experiment().grasp().contact_margin() + 1e-12);
      EXPECT_GT(c.mu, 0);
      if (k > 0) {
        const Contact& b = report.contacts[k - 1];
        EXPECT_TRUE(b.link < c.link || (b.link == c.link && b.part <= c.part)) << "trial " << i;
      }
      ++seen;
    }
  }
  EXPECT_GT(seen, 100);
}

TEST_F(SimulatorTest, ThetaIsTheSumOfItsTwoAngles) {
  GraspReport report;
  const Measurement m = run(above({0.1, 0.05, 0.3}), &report);
  // The finger axis and the thumb by hand from the report: angle(V2, V3) alone bounds theta from below.
  const Vec3 to_target = m.o - report.palm.position;
  const Vec3 fingers = report.palm.rotation * from_proto(sim_->hand().finger_axis());
  const double second = std::acos(to_target.normalized().dot(fingers.normalized())) * 180 / det::kPi;
  EXPECT_GE(m.theta, second - 1e-9);
  EXPECT_LE(m.theta, second + 180);
}

TEST_F(SimulatorTest, FrictionComesFromThePairOfMaterials) {
  proto::Experiment experiment = sim_->experiment();
  auto* pair = experiment.mutable_scene()->add_friction();
  pair->set_a(sim_->hand().link(1).material());
  pair->set_b(sim_->object(0).material());
  pair->set_mu(0.123);
  const auto other = Simulator::create(experiment, {sim_->object(0)}, sim_->hand());
  ASSERT_TRUE(other) << other.error().message;
  const auto workspace = (*other)->make_workspace();
  int seen = 0;
  for (std::uint64_t i = 0; i < 50; ++i) {
    const testing::Trial t = testing::random_trial(**other, i);
    GraspReport report;
    (*other)->get_quality(t.placements, 0, t.tool, *workspace, &report);
    for (const Contact& c : report.contacts) {
      EXPECT_EQ(c.mu, 0.123);
      ++seen;
    }
  }
  EXPECT_GT(seen, 20);
}

TEST_F(SimulatorTest, WhatCannotBeSimulatedIsRefusedWithItsReason) {
  const auto refused = [&](const proto::Experiment& e, const std::vector<proto::ObjectBundle>& o,
                           const proto::HandBundle& h, const std::string& reason) {
    const auto sim = Simulator::create(e, o, h);
    ASSERT_FALSE(sim) << reason;
    EXPECT_NE(sim.error().message.find(reason), std::string::npos) << sim.error().message;
  };
  const proto::Experiment good = sim_->experiment();
  refused(good, {}, sim_->hand(), "no object");
  proto::HandBundle hand = sim_->hand();
  hand.mutable_joint(0)->set_upper(std::numeric_limits<double>::quiet_NaN());
  refused(good, {sim_->object(0)}, hand, "limits");
  hand = sim_->hand();
  hand.mutable_motor(0)->set_joint(0, 99);
  refused(good, {sim_->object(0)}, hand, "not there");
  hand = sim_->hand();
  hand.mutable_joint(1)->set_parent_link(7);
  refused(good, {sim_->object(0)}, hand, "before its parent");
  hand = sim_->hand();
  hand.clear_joint();
  refused(good, {sim_->object(0)}, hand, "one joint a link");
  proto::ObjectBundle object = sim_->object(0);
  object.mutable_part(0)->mutable_box()->set_hx(-1);
  refused(good, {object}, sim_->hand(), "size");
}

}  // namespace
}  // namespace evograsp::sim
