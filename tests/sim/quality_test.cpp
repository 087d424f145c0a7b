#include "sim/quality.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "tests/sim/contact_sets.h"

namespace evograsp::sim {
namespace {

constexpr double kTight = 1e-12;

Wrench unit(int axis, double length) {
  Wrench w{};
  w[axis] = length;
  return w;
}

Contact contact_at(const Vec3& point, const Vec3& normal, double mu) {
  return {point, normal, mu, 0, 0, 0};
}

TEST(EpsilonTest, CrossPolytopeHasItsInradius) {
  std::vector<Wrench> points;
  for (int axis = 0; axis < 6; ++axis) {
    points.push_back(unit(axis, 3));
    points.push_back(unit(axis, -3));
  }
  EXPECT_NEAR(Epsilon()(points), 3 / std::sqrt(6.0), kTight);
}

TEST(EpsilonTest, BoxWhoseFacetsHold32VerticesEachHasItsShortestHalfSize) {
  const double half[6] = {1.5, 0.7, 0.9, 0.31, 2.5, 1};
  std::vector<Wrench> corners;
  for (int bits = 0; bits < 64; ++bits) {
    Wrench w;
    for (int x = 0; x < 6; ++x) w[x] = (bits >> x & 1) != 0 ? half[x] : -half[x];
    corners.push_back(w);
  }
  Epsilon epsilon;
  EXPECT_NEAR(epsilon(corners), 0.31, kTight);
  EXPECT_NEAR(std::fabs(epsilon.weakest()[3]), 1, kTight) << "the weakest direction is the box's short axis";
}

TEST(EpsilonTest, ScalesWithTheWrenches) {
  auto wrenches = testing::draw_wrenches(testing::Kind::kBlob, 6, 1);
  Epsilon epsilon;
  const double one = epsilon(wrenches);
  ASSERT_GT(one, 0);
  for (const double factor : {1e-6, 0.125, 7.0, 1e9}) {
    auto scaled = wrenches;
    for (Wrench& w : scaled) {
      for (double& x : w) x *= factor;
    }
    EXPECT_NEAR(epsilon(scaled) / factor, one, kTight) << "factor " << factor;
  }
}

TEST(EpsilonTest, IsZeroWhereTheOriginIsNotStrictlyInside) {
  Epsilon epsilon;
  EXPECT_EQ(epsilon({}), 0);
  const std::vector<Wrench> same(20, unit(0, 1));
  EXPECT_EQ(epsilon(same), 0) << "one point twenty times";

  std::vector<Wrench> simplex;  // the origin is one of the corners
  for (int axis = 0; axis < 6; ++axis) simplex.push_back(unit(axis, 1));
  simplex.push_back(unit(0, 0));
  EXPECT_EQ(epsilon(simplex), 0) << "origin at a corner";
  simplex.back() = unit(0, -1);
  EXPECT_EQ(epsilon(simplex), 0) << "origin in a facet";

  std::vector<Wrench> flat;  // spans five of six dimensions
  for (int axis = 0; axis < 5; ++axis) {
    flat.push_back(unit(axis, 1));
    flat.push_back(unit(axis, -1));
  }
  EXPECT_EQ(epsilon(flat), 0) << "flat";
  flat.push_back(unit(5, 1));
  EXPECT_EQ(epsilon(flat), 0) << "a pyramid with the origin in its base";
  flat.push_back(unit(5, -1e-3));
  EXPECT_GT(epsilon(flat), 0.0009) << "a thin pyramid below the base lets the origin in";
}

TEST(EpsilonTest, NeverGivesNaN) {
  auto wrenches = testing::draw_wrenches(testing::Kind::kBlob, 5, 1);
  Epsilon epsilon;
  ASSERT_GT(epsilon(wrenches), 0);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    auto broken = wrenches;
    broken[7][3] = bad;
    EXPECT_EQ(epsilon(broken), 0);
  }
  EXPECT_GT(epsilon(wrenches), 0) << "and a bad set leaves nothing behind";
}

TEST(EpsilonTest, RepeatedWrenchesAndInnerOnesChangeNothing) {
  Epsilon epsilon;
  for (const testing::Kind kind : testing::kKinds) {
    auto wrenches = testing::draw_wrenches(kind, 6, 3);
    const double one = epsilon(wrenches);
    const auto once = wrenches;
    wrenches.insert(wrenches.end(), once.begin(), once.end());
    for (std::size_t i = 1; i < once.size(); ++i) {
      Wrench middle;
      for (int x = 0; x < 6; ++x) middle[x] = (once[i][x] + once[i - 1][x]) / 2;
      wrenches.push_back(middle);
    }
    EXPECT_NEAR(epsilon(wrenches), one, 1e-10) << "kind " << static_cast<int>(kind);
  }
}

TEST(QualityTest, EdgesHaveNormalPartOneAndTorqueAboutTheCentreOverTheScale) {
  const Vec3 com(0.1, -0.2, 0.3), point(0.15, -0.2, 0.31), normal(-1, 0, 0);
  const Contact contact = contact_at(point, normal, 0.5);
  Quality quality(ConeModel{.edges = 8});
  const auto wrenches = quality.wrenches({&contact, 1}, com, 0.05);
  ASSERT_EQ(wrenches.size(), 8u);
  // The arm is (0.05, 0, 0.01): edge 0 leans toward +z.
  EXPECT_NEAR(wrenches[0][2], 0.5, kTight);
  for (const Wrench& w : wrenches) {
    const Vec3 force(w[0], w[1], w[2]);
    EXPECT_NEAR(force.dot(normal), 1, kTight);
    EXPECT_NEAR((force - normal).norm(), 0.5, kTight);
    const Vec3 torque = (point - com).cross(force) / 0.05;
    EXPECT_NEAR((torque - Vec3(w[3], w[4], w[5])).norm(), 0, kTight);
  }
  Quality lengths(ConeModel{.edges = 5, .unit_length = true});
  for (const Wrench& w : lengths.wrenches({&contact, 1}, com, 0.05)) {
    EXPECT_NEAR(Vec3(w[0], w[1], w[2]).norm(), 1, kTight);
  }
}

TEST(QualityTest, TwoOpposedPointContactsCannotResistTorqueAboutTheirLine) {
  std::vector<Contact> contacts = {contact_at({0.03, 0, 0}, {-1, 0, 0}, 0.8),
                                   contact_at({-0.03, 0, 0}, {1, 0, 0}, 0.8)};
  EXPECT_EQ(Quality()(contacts, Vec3::Zero(), 0.05), 0);
  // The same two, each touched twice: four contacts, still on one line.
  contacts.insert(contacts.end(), {contacts[0], contacts[1]});
  EXPECT_EQ(Quality()(contacts, Vec3::Zero(), 0.05), 0);
}

// Cube of half size 1, com at the origin, torque scale 1, friction 1/2, pyramids of four edges along y and z.
// Contacts at (1, 0, 0) and (-1, +-1/2, 0), all pushing along x. The polar body {n : n . w <= 1 for every
// wrench w} has its farthest corner at distance 1 / epsilon. With n = (X, Y, Z, a, b, c) it is
//   -X + |Y + c| / 2 <= 1             -X + |Z - b| / 2 <= 1
//    X -+ c / 2 + |Y - c| / 2 <= 1     X -+ c / 2 + |Z + b +- a / 2| / 2 <= 1
// and that corner is X = -1 (so Y = -c, Z = b), c = 4/3, a = 8, b = 2/3: its squared length is
// 1 + 16/9 + 4/9 + 64 + 4/9 + 16/9 = 625/9, so epsilon = 3/25.
TEST(QualityTest, CubeWithThreeFrictionalContactsHasEpsilon3Over25) {
  const std::vector<Contact> contacts = {contact_at({1, 0, 0}, {-1, 0, 0}, 0.5),
                                         contact_at({-1, 0.5, 0}, {1, 0, 0}, 0.5),
                                         contact_at({-1, -0.5, 0}, {1, 0, 0}, 0.5)};
  EXPECT_NEAR(Quality(ConeModel{.edges = 4})(contacts, Vec3::Zero(), 1), 0.12, kTight);
}

std::vector<Contact> tetrahedron(double mu) {
  std::vector<Contact> contacts;
  for (const Vec3& corner : {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)}) {
    contacts.push_back(contact_at(corner.normalized(), -corner.normalized(), mu));
  }
  return contacts;
}

// A sphere's normals pass through its centre: without friction nothing turns it. With friction mu, contacts
// at -n_i and torque scale 1, the round cone of contact i reaches along a unit wrench (a, b) as far as
//   n_i . a + mu |a - (n_i . a) n_i + n_i x b|.
// Along a = s n_1, b = sqrt(1 - s^2) n_1 the two tangential parts are at right angles, both sqrt(8)/3 long
// per unit, and vanish at contact 1: that one reaches s, the others (n_i . n_1 = -1/3) reach -s/3 + mu
// sqrt(8)/3. All four reach mu / sqrt(2) when s is that: the round cones' epsilon is no more. It is no less
// than that of pyramids inside them, so 64 edges that come within a thousandth of the bound show that it is
// the value.
TEST(QualityTest, TetrahedralContactsOnASphereNeedFriction) {
  Quality quality(ConeModel{.edges = 64});
  EXPECT_EQ(quality(tetrahedron(0), Vec3::Zero(), 1), 0);
  for (const double mu : {0.05, 0.1, 0.2, 0.5, 1.0}) {
    const double exact = mu / std::sqrt(2.0);
    const double epsilon = quality(tetrahedron(mu), Vec3::Zero(), 1);
    EXPECT_LE(epsilon, exact) << "mu " << mu;
    EXPECT_GT(epsilon, 0.999 * exact) << "mu " << mu;
  }
}

TEST(QualityTest, FewerThanThreeContactsAndWeakGraspsAreZero) {
  const auto contacts = testing::draw_contacts(testing::Kind::kBlob, 6, 1);
  const double epsilon = Quality()(contacts, Vec3::Zero(), testing::kTorqueScale);
  ASSERT_GT(epsilon, 0.01);
  EXPECT_EQ(Quality()({contacts.data(), 2}, Vec3::Zero(), testing::kTorqueScale), 0);
  EXPECT_EQ(Quality({}, epsilon * 1.01)(contacts, Vec3::Zero(), testing::kTorqueScale), 0);
  EXPECT_EQ(Quality({}, epsilon * 0.99)(contacts, Vec3::Zero(), testing::kTorqueScale), epsilon);
}

TEST(WrenchHullTest, BoxHasItsVolumeAndItsWeakestDirection) {
  const double half[6] = {1, 2, 0.5, 1, 1, 3};
  std::vector<Wrench> corners;
  for (int bits = 0; bits < 64; ++bits) {
    Wrench w;
    for (int x = 0; x < 6; ++x) w[x] = (bits >> x & 1) != 0 ? half[x] : -half[x];
    corners.push_back(w);
  }
  const auto hull = wrench_hull(corners);
  ASSERT_TRUE(hull) << hull.error().message;
  EXPECT_TRUE(hull->force_closure);
  EXPECT_NEAR(hull->volume, 64 * 3.0, 1e-9);
  EXPECT_NEAR(hull->epsilon, 0.5, kTight);
  EXPECT_NEAR(std::fabs(hull->weakest[2]), 1, kTight);
}

TEST(WrenchHullTest, FlatSetsHaveNoVolumeAndBadOnesAnError) {
  const auto two = testing::draw_wrenches(testing::Kind::kCorners, 2, 1);
  const auto flat = wrench_hull(two);
  ASSERT_TRUE(flat) << flat.error().message;
  EXPECT_FALSE(flat->force_closure);
  EXPECT_TRUE(wrench_hull({}));
  auto broken = testing::draw_wrenches(testing::Kind::kBlob, 5, 1);
  broken[3][2] = std::numeric_limits<double>::infinity();
  const auto error = wrench_hull(broken);
  ASSERT_FALSE(error);
  EXPECT_EQ(error.error().code, ErrorCode::kInvalid);
  const std::vector<Wrench> point(12, unit(2, 1));
  const auto degenerate = wrench_hull(point);
  ASSERT_TRUE(degenerate) << degenerate.error().message;
  EXPECT_EQ(degenerate->volume, 0);
}

}  // namespace
}  // namespace evograsp::sim
