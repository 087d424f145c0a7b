// The approach against a brute-force sweep in steps of 0.1 mm, and against things too thin for any step.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/approach.h"
#include "tests/sim/attempt_parts.h"

namespace evograsp::sim {
namespace {

using testing::AttemptParts;

// The last 0.1 mm step along the way at which no part is within the tolerance of anything.
double swept(AttemptParts& parts, const testing::Trial& trial, bool* blocked) {
  const Pose start = parts.start(trial.tool);
  const Vec3 d = parts.direction(trial.tool);
  const double step = 1e-4;
  double travelled = 0;
  for (int i = 0; i * step <= parts.hand.standoff(); ++i) {
    Pose palm = start;
    palm.position += i * step * d;
    parts.state.open(parts.hand, palm);
    for (std::size_t p = 0; p < parts.hand.parts().size(); ++p) {
      const Aabb box = bounds(parts.hand.parts()[p].shape, parts.state.part[p]);
      for (const Obstacle& o : parts.posed.obstacle) {
        if (!box.overlaps(o.box, parts.tolerance)) continue;
        if (distance(parts.hand.parts()[p].shape, parts.state.part[p], o).distance > parts.tolerance)
          continue;
        *blocked = i == 0;
        return travelled;
      }
    }
    travelled = i * step;
  }
  *blocked = false;
  return parts.hand.standoff();
}

TEST(Approach, StopsWhereA100MicrometreSweepStops) {
  const auto sim = testing::make_simulator({"cylinder", "cube", "sphere", "mug"});
  AttemptParts parts(*sim);
  int stopped = 0, blocked = 0, grazing = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    const testing::Trial trial = testing::random_trial(*sim, i);
    const bool free = parts.approach_only(trial);
    const double travelled = (parts.state.link[0].position - parts.start(trial.tool).position).norm();
    bool sweep_blocked = false;
    const double reference = swept(parts, trial, &sweep_blocked);
    ASSERT_EQ(free, !sweep_blocked) << "trial " << i;
    if (!free) {
      ++blocked;
      EXPECT_EQ(travelled, 0) << "a blocked hand stays at its start, trial " << i;
      continue;
    }
    // Never sooner than the sweep; later only where a grazing approach turns the 0.02 mm between resting gap
    // and tolerance into more along the way.
    EXPECT_GT(travelled, reference - 1e-6) << "trial " << i;
    grazing += travelled > reference + 3e-4;
    if (travelled < parts.hand.standoff() - 1e-6) {
      parts.approach_only(trial);
      const double gap = parts.clearance();
      EXPECT_GT(gap, 0) << "trial " << i;
      EXPECT_LE(gap, parts.tolerance + 1e-7) << "trial " << i;
    }
    stopped += travelled < parts.hand.standoff() - 1e-6;
  }
  EXPECT_GT(stopped, 50);
  EXPECT_LE(grazing, stopped / 20);
  EXPECT_GT(blocked, 20);
}

// A plate a hundredth of a millimetre thick across the way of a hand that comes from 15 cm.
TEST(Approach, DoesNotTunnelThroughAThinPlate) {
  const auto sim = testing::make_simulator({"cube"});
  proto::ObjectBundle plate = sim->object(0);
  plate.clear_part();
  proto::ConvexPart* part = plate.add_part();
  part->mutable_box()->set_hx(0.3);
  part->mutable_box()->set_hy(0.3);
  part->mutable_box()->set_hz(5e-6);
  const HandModel hand = *HandModel::create(sim->hand());
  const World world = *World::create(sim->experiment().scene(), {plate});
  HandState state(hand);
  ApproachScratch scratch;
  PosedWorld posed;
  Random random(5, Purpose::kTestHarness);
  for (int i = 0; i < 2000; ++i) {
    Placements placements;
    placements.pose = {Pose{rotation_about(Vec3::UnitY(), random.uniform(-0.6, 0.6)), Vec3(0, 0, 0.5)}};
    placements.resting = {0};
    placements.present = {1};
    world.place(placements, posed);
    const Pose tool = testing::random_tool_pose(random, Vec3(0, 0, 0.5), 0.02);
    const Vec3 d = tool.rotation * hand.approach_axis();
    const double length = random.uniform(0.3, 3);
    Pose palm{tool.rotation, tool.position - length * d};
    state.open(hand, palm);
    const ApproachResult way = approach(hand, state, posed, d, 2 * length, 2e-4, scratch);
    const double closing = std::fabs(d.dot(placements.pose[0].rotation.col(2)));
    if (closing < 0.5) continue;  // along the plate: it may pass beside it
    ASSERT_LT(way.travelled, length + 0.3) << "trial " << i;
    palm.position += way.travelled * d;
    state.open(hand, palm);
    double least = 1;
    for (std::size_t p = 0; p < hand.parts().size(); ++p)
      for (const Obstacle& o : posed.obstacle)
        least = std::min(least, distance(hand.parts()[p].shape, state.part[p], o).distance);
    if (!way.blocked) {
      ASSERT_GT(least, 0) << "trial " << i;
      ASSERT_LE(least, 2e-4 + 1e-7) << "trial " << i;
    }
  }
}

// The same for a finger that closes: a blade in its way, seen edge on.
TEST(Closing, FingersDoNotPassThroughAThinBlade) {
  const auto sim = testing::make_simulator({"cube"});
  proto::ObjectBundle blade = sim->object(0);
  blade.clear_part();
  proto::ConvexPart* part = blade.add_part();
  part->mutable_box()->set_hx(0.2);
  part->mutable_box()->set_hy(0.2);
  part->mutable_box()->set_hz(1e-6);
  const HandModel hand = *HandModel::create(sim->hand(), 2e-4);
  const World world = *World::create(sim->experiment().scene(), {blade});
  HandState state(hand);
  Closing closing(hand, world.part_count());
  PosedWorld posed;
  Random random(6, Purpose::kTestHarness);
  int held = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose at = testing::random_tool_pose(random, Vec3(0, 0, 0.6), 0.08);
    Placements placements;
    placements.pose = {at};
    placements.resting = {0};
    placements.present = {1};
    world.place(placements, posed);
    state.open(hand, Pose{Mat3::Identity(), Vec3(0, 0, 0.6)});
    const auto side = [&](std::size_t p) {
      const Vec3 c = state.part[p] * hand.parts()[p].shape.centre;
      return (at.rotation.transpose() * (c - at.position)).z() > 0;
    };
    const auto clear = [&](std::size_t p) {
      return distance(hand.parts()[p].shape, state.part[p], posed.obstacle[1]).distance > 0;
    };
    bool free = true;
    std::vector<bool> before;
    for (std::size_t p = 0; p < hand.parts().size(); ++p) {
      free = free && clear(p);
      before.push_back(side(p));
    }
    if (!free) continue;
    closing.close(hand, posed, 2e-4, state);
    for (std::size_t p = 0; p < hand.parts().size(); ++p) {
      ASSERT_TRUE(clear(p)) << "part " << p << ", trial " << i;
      const Vec3 c = at.rotation.transpose() * (state.part[p] * hand.parts()[p].shape.centre - at.position);
      if (std::fabs(c.x()) < 0.1 && std::fabs(c.y()) < 0.1) {
        ASSERT_EQ(side(p), before[p]) << "part " << p << ", trial " << i;
      }
    }
    ++held;
  }
  EXPECT_GT(held, 50);
}

}  // namespace
}  // namespace evograsp::sim
