// Laws of epsilon on thousands of contact sets. EVOGRASP_LONG=1 in the environment holds 10,000 of them, not
// 1,000, against qhull (some five minutes of one core).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "common/det_math.h"
#include "sim/polytope6.h"
#include "tests/sim/contact_sets.h"
#include "tests/sim/hull_oracle.h"

namespace evograsp::sim {
namespace {

using testing::Kind;
using Polytope = Polytope6<double>;
using Wide = long double;
using WidePoint = std::array<Wide, 6>;

constexpr int kSets = 10000;
constexpr int kMinContacts = 3, kMaxContacts = 20;

bool long_run() {
  return std::getenv("EVOGRASP_LONG") != nullptr;
}
int contacts_of(int set) {
  return kMinContacts + set % (kMaxContacts - kMinContacts + 1);
}

Wide dot(const WidePoint& a, const WidePoint& b) {
  Wide sum = 0;
  for (int x = 0; x < 6; ++x) sum += a[x] * b[x];
  return sum;
}

// The plane n . x = 1 through six points, by Gaussian elimination in 64-bit mantissas.
bool plane_through(std::array<WidePoint, 6> m, WidePoint& n) {
  n.fill(1);
  for (int k = 0; k < 6; ++k) {
    int pivot = k;
    for (int r = k + 1; r < 6; ++r) {
      if (std::fabs(m[r][k]) > std::fabs(m[pivot][k])) pivot = r;
    }
    if (std::fabs(m[pivot][k]) < 1e-12L) return false;
    std::swap(m[k], m[pivot]);
    std::swap(n[k], n[pivot]);
    for (int r = k + 1; r < 6; ++r) {
      const Wide f = m[r][k] / m[k][k];
      for (int x = k; x < 6; ++x) m[r][x] -= f * m[k][x];
      n[r] -= f * n[k];
    }
  }
  for (int k = 5; k >= 0; --k) {
    for (int x = k + 1; x < 6; ++x) n[k] -= m[k][x] * n[x];
    n[k] /= m[k][k];
  }
  return true;
}

// Proves a radius from the facets it rests on, with arithmetic of its own: the surface is closed and convex
// at every ridge, it goes once around a point inside, so it bounds a convex polytope of hull points; all its
// planes are at least `radius` away (epsilon is no less), and no wrench reaches beyond `radius` along
// `direction` (no more).
class Certificate {
 public:
  Certificate(const Polytope& polytope, const std::vector<Wrench>& points) : facets_(polytope.facets()) {
    for (int id = 0; id < polytope.size(); ++id) {
      if (facets_[id].alive) alive_.push_back(id);
    }
    // Any corners do: the middle of all of them is inside.
    WidePoint middle{};
    int corners = 0;
    for (int id : alive_) {
      for (int v : facets_[id].vertex) {
        for (int x = 0; x < 6; ++x) middle[x] += points[v][x];
        ++corners;
      }
    }
    for (int x = 0; x < 6; ++x) centre_[x] = middle[x] / corners;
    for (const Wrench& w : points) {
      WidePoint p;
      for (int x = 0; x < 6; ++x) p[x] = w[x] - centre_[x];
      points_.push_back(p);
    }
  }

  void check(double radius, const Wrench& direction) {
    planes_.resize(facets_.size());
    for (int id : alive_) {
      ASSERT_TRUE(plane_through(corners(id), planes_[id])) << "a facet without a plane";
      const Wide distance = (1 + dot(planes_[id], centre_)) / std::sqrt(dot(planes_[id], planes_[id]));
      ASSERT_GE(distance, radius - 1e-10) << "a facet nearer than epsilon";
      check_ridges(id);
    }
    check_winding();
    Wide reach = -1;
    const WidePoint along{direction[0], direction[1], direction[2], direction[3], direction[4], direction[5]};
    for (const WidePoint& p : points_) reach = std::max(reach, dot(along, p) + dot(along, centre_));
    ASSERT_NEAR(static_cast<double>(reach), radius, 1e-11) << "the hull's nearest facet is elsewhere";
    ASSERT_NEAR(static_cast<double>(dot(along, along)), 1, 1e-12);
  }

 private:
  std::array<WidePoint, 6> corners(int id) const {
    std::array<WidePoint, 6> m;
    for (int k = 0; k < 6; ++k) m[k] = points_[facets_[id].vertex[k]];
    return m;
  }

  void check_ridges(int id) {
    for (int k = 0; k < 6; ++k) {
      const auto [next, slot] = facets_[id].across(k);
      ASSERT_TRUE(next >= 0 && next < static_cast<int>(facets_.size())) << "a hole";
      ASSERT_TRUE(facets_[next].alive) << "a dead neighbour";
      ASSERT_EQ(facets_[next].across(slot).facet, id) << "a ridge known to one side only";
      ASSERT_EQ(facets_[next].across(slot).slot, k) << "a ridge known to one side only";
      const int opposite = facets_[next].vertex[slot];
      ASSERT_LE(dot(planes_[id], points_[opposite]), 1 + 1e-9) << "a ridge that is not convex";
      for (int v : facets_[next].vertex) {
        const auto& own = facets_[id].vertex;
        ASSERT_TRUE(v == opposite || std::find(own.begin(), own.end(), v) != own.end()) << "a false ridge";
      }
    }
  }

  // How many facets does a ray from the centre cross? x = sum of s_j corner_j with all s_j > 0.
  void check_winding() {
    const WidePoint ray{0.31L, -0.22L, 0.44L, 0.17L, -0.39L, 0.27L};
    int crossings = 0;
    for (int id : alive_) {
      const auto m = corners(id);
      std::array<WidePoint, 6> columns;
      for (int r = 0; r < 6; ++r) {
        for (int k = 0; k < 6; ++k) columns[r][k] = m[k][r] / ray[r];
      }
      WidePoint share;
      if (!plane_through(columns, share)) continue;
      crossings += std::all_of(share.begin(), share.end(), [](Wide s) { return s > 0; }) ? 1 : 0;
    }
    ASSERT_EQ(crossings, 1) << "the surface does not go once around its middle";
  }

  const std::vector<Polytope::Facet>& facets_;
  std::vector<int> alive_;
  std::vector<WidePoint> points_, planes_;
  WidePoint centre_{};
};

std::vector<Wrench> small(std::vector<Wrench> wrenches) {
  for (Wrench& w : wrenches) {
    for (double& x : w) x /= 8;
  }
  return wrenches;
}

TEST(EpsilonPropertyTest, TenThousandSetsCarryAProof) {
  Polytope polytope;
  int closed = 0;
  for (int set = 0; set < kSets; ++set) {
    const auto wrenches = small(testing::draw_wrenches(Kind::kBlob, contacts_of(set), set));
    const auto outcome = polytope.expand(wrenches);
    if (outcome != Polytope::Outcome::kInside) {
      ASSERT_EQ(outcome, Polytope::Outcome::kOutside) << "set " << set;
      continue;
    }
    ++closed;
    Certificate(polytope, wrenches).check(polytope.radius(), polytope.direction());
    if (::testing::Test::HasFatalFailure()) FAIL() << "set " << set;
  }
  EXPECT_GT(closed, kSets * 3 / 4) << "too few closed grasps to prove anything";
}

// Sets of 3 to 20 contacts of every kind, drawn until that many have been compared with qhull's hull.
TEST(EpsilonPropertyTest, EqualsQhull) {
  Epsilon epsilon;
  const int wanted = long_run() ? kSets : 1000;
  int compared = 0, closed = 0, failed = 0;
  for (int set = 0; compared < wanted; ++set) {
    const int contacts = contacts_of(set);
    const auto wrenches = testing::draw_wrenches(testing::kKinds[set / 18 % 4], contacts, set);
    const auto want = testing::qhull_epsilon(wrenches, testing::kExactOptions);
    if (!want) {
      ASSERT_LE(++failed, 2 + wanted / 100) << "too many sets defeat qhull";
      continue;
    }
    const double got = epsilon(wrenches);
    ASSERT_NEAR(got, *want, 1e-9) << "set " << set << " of " << contacts << " contacts";
    ++compared;
    closed += got > 0 ? 1 : 0;
  }
  EXPECT_GT(closed, wanted * 3 / 4) << "too few closed grasps to prove anything";
  std::printf("%d sets equal to qhull's, %d of them closed; %d defeated qhull\n", compared, closed, failed);
}

// Sets full of coplanar and repeated wrenches: 113-bit arithmetic on points in general position, 1e-11 away,
// cannot be confused by them.
TEST(EpsilonPropertyTest, DegenerateSetsEqualTheirNeighboursInGeneralPosition) {
  Epsilon epsilon;
  Polytope6<Quad> careful;
  for (int set = 0; set < 120; ++set) {
    const auto wrenches = testing::draw_wrenches(testing::kKinds[1 + set % 3], kMinContacts + set % 4, set);
    Random random(set, Purpose::kTestHarness);
    std::vector<Polytope6<Quad>::Point> moved;
    for (const Wrench& w : wrenches) {
      Polytope6<Quad>::Point p;
      for (int x = 0; x < 6; ++x) p[x] = w[x] / 8 + 1e-11 * random.uniform(-1, 1);
      moved.push_back(p);
    }
    const auto outcome = careful.expand(moved);
    ASSERT_NE(outcome, Polytope6<Quad>::Outcome::kGaveUp) << "set " << set;
    const double want =
        outcome == Polytope6<Quad>::Outcome::kInside ? 8 * static_cast<double>(careful.radius()) : 0;
    ASSERT_NEAR(epsilon(wrenches), want, 1e-9) << "set " << set;
  }
}

TEST(QualityPropertyTest, ARigidMotionChangesNothing) {
  Quality quality;
  for (int set = 0; set < 2000; ++set) {
    const Kind kind = testing::kKinds[set % 4];
    auto contacts = testing::draw_contacts(kind, 4 + set % 5, set);
    const double still = quality(contacts, Vec3::Zero(), testing::kTorqueScale);
    Random random(set, Purpose::kTestHarness, 99);
    const Vec3 axis = testing::draw_vector(random);
    const Pose motion{axis_angle(axis, random.uniform(-det::kPi, det::kPi)), testing::draw_vector(random)};
    for (Contact& c : contacts) {
      c.point = motion * c.point;
      c.normal = motion.rotation * c.normal;
    }
    ASSERT_NEAR(quality(contacts, motion.position, testing::kTorqueScale), still, 1e-10) << "set " << set;
  }
}

TEST(QualityPropertyTest, TheOrderOfContactsChangesNothing) {
  Quality quality;
  for (int set = 0; set < 2000; ++set) {
    auto contacts = testing::draw_contacts(testing::kKinds[set % 2], 4 + set % 5, set);
    const double one = quality(contacts, Vec3::Zero(), testing::kTorqueScale);
    std::reverse(contacts.begin(), contacts.end());
    std::rotate(contacts.begin(), contacts.begin() + set % 4, contacts.end());
    ASSERT_NEAR(quality(contacts, Vec3::Zero(), testing::kTorqueScale), one, 1e-10) << "set " << set;
  }
}

TEST(QualityPropertyTest, AnotherContactNeverMakesAGraspWorse) {
  Epsilon epsilon;
  for (int set = 0; set < 1000; ++set) {
    auto wrenches = testing::draw_wrenches(testing::kKinds[set % 4], 5, set);
    const double five = epsilon(wrenches);
    const auto more = testing::draw_wrenches(testing::kKinds[set % 4], 1, set + 5000);
    wrenches.insert(wrenches.end(), more.begin(), more.end());
    ASSERT_GE(epsilon(wrenches), five - 1e-10) << "set " << set;
  }
}

}  // namespace
}  // namespace evograsp::sim
