// Built-in objects against formulas worked by hand, and the mug's hollow.
#include <gtest/gtest.h>
#include <zstd.h>

#include <Eigen/Geometry>
#include <cmath>

#include "assets/assets.h"
#include "assets/parts.h"
#include "common/digest.h"
#include "common/pose.h"

namespace evograsp::assets {
namespace {

proto::ObjectBundle load(const std::string& name) {
  const Result<LoadedObject> object = load_object(name, {});
  EXPECT_TRUE(object) << (object ? "" : object.error().message);
  return object ? object->bundle : proto::ObjectBundle();
}

TEST(Builtin, EveryNameLoadsWithoutWarningsAndRestsOnTheTable) {
  const std::vector<std::string> names = builtin_objects();
  for (const char* wanted :
       {"cylinder", "cuboid", "cube_6cm", "cube_5cm", "sphere_4cm", "sphere_3cm", "mug", "plated_mug"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), wanted), names.end()) << wanted;
    const Result<LoadedObject> object = load_object(wanted, {});
    ASSERT_TRUE(object) << object.error().message;
    EXPECT_TRUE(object->warnings.empty());
    EXPECT_EQ(object->bundle.name(), wanted);
    EXPECT_EQ(object->id.size(), 64u);
    ASSERT_GE(object->bundle.resting_size(), 1);
    for (const proto::RestingPose& rest : object->bundle.resting()) {
      const Vec3 down = from_proto(rest.orientation()).transpose() * -Vec3::UnitZ();
      double lowest = -1;
      for (const auto& part : object->bundle.part()) lowest = std::max(lowest, support(part, down));
      EXPECT_NEAR(rest.height(), lowest, 1e-12) << wanted;
    }
  }
}

TEST(Builtin, AliasesAreTheSameObject) {
  EXPECT_EQ(load_object("cube", {})->id, load_object("cube_6cm", {})->id);
  EXPECT_EQ(load_object("sphere", {})->id, load_object("sphere_4cm", {})->id);
}

TEST(Builtin, CylinderHasTheFormulasMassInertiaAndReach) {
  const proto::ObjectBundle o = load("cylinder");
  const double r = 0.03, h = 0.12, m = 400 * M_PI * r * r * h;
  EXPECT_NEAR(o.mass(), m, 1e-12);
  EXPECT_NEAR(o.inertia(0), m * (3 * r * r + h * h) / 12, 1e-12);
  EXPECT_NEAR(o.inertia(2), m * r * r / 2, 1e-12);
  EXPECT_NEAR(o.inertia(3), 0, 1e-15);
  EXPECT_NEAR(o.resting(0).height(), 0.06, 1e-12);
  EXPECT_NEAR(o.footprint_radius(), 0.03, 1e-12);
  // The corner (r, h/2) is rounded by 0.5 mm.
  EXPECT_NEAR(o.torque_scale(), std::sqrt(0.0295 * 0.0295 + 0.0595 * 0.0595) + 0.0005, 1e-12);
}

TEST(Builtin, SphereReachesItsRadiusEverywhere) {
  const proto::ObjectBundle o = load("sphere_3cm");
  EXPECT_DOUBLE_EQ(o.torque_scale(), 0.03);
  EXPECT_DOUBLE_EQ(o.footprint_radius(), 0.03);
  EXPECT_DOUBLE_EQ(o.resting(0).height(), 0.03);
  EXPECT_NEAR(o.inertia(1), 0.4 * o.mass() * 9e-4, 1e-15);
}

TEST(Builtin, CubeFootprintReachesItsRoundedEdges) {
  const proto::ObjectBundle o = load("cube");
  EXPECT_NEAR(o.footprint_radius(), std::sqrt(2.0) * 0.0295 + 0.0005, 1e-12);
  EXPECT_NEAR(o.mass(), 400 * 0.06 * 0.06 * 0.06, 1e-12);
}

// Signed volume: positive when closed and outward.
double volume(const proto::TriangleMesh& mesh) {
  const auto at = [&](int i) {
    const int v = static_cast<int>(mesh.triangle(i)) * 3;
    return Vec3(mesh.xyz(v), mesh.xyz(v + 1), mesh.xyz(v + 2));
  };
  double sum = 0;
  for (int t = 0; t + 2 < mesh.triangle_size(); t += 3) sum += at(t).dot(at(t + 1).cross(at(t + 2))) / 6;
  return sum;
}

TEST(Builtin, MugVisualEnclosesItsMaterial) {
  const proto::ObjectBundle o = load("mug");
  const double ro = 0.041, ri = 0.037, h = 0.095, floor = 0.006;
  const double cup = M_PI * (ro * ro * h - ri * ri * (h - floor));
  // The handle: half an ellipse's perimeter (Ramanujan) times its cross-section.
  const double a = 0.0285, b = 0.0255,
               perimeter = M_PI * (3 * (a + b) - std::sqrt((3 * a + b) * (a + 3 * b))) / 2;
  const double handle = perimeter * M_PI * 0.0045 * 0.0045;
  EXPECT_NEAR(volume(o.visual()), cup + handle, 0.03 * (cup + handle));
}

TEST(Builtin, MugCentreLeansTowardsItsHandle) {
  const proto::ObjectBundle o = load("mug");
  EXPECT_GT(o.centre_of_mass().x(), 0.001);
  EXPECT_LT(o.centre_of_mass().x(), 0.01);
  EXPECT_NEAR(o.centre_of_mass().y(), 0, 1e-12);
  EXPECT_LT(o.centre_of_mass().z(), 0);  // the floor is below, the opening above
}

// Largest penetration-free radius: distance from p to the nearest part, by projecting on sampled directions
// (separating planes): exact enough for convex parts and never too large by more than the sampling.
double clearance(const proto::ConvexPart& part, const Vec3& p) {
  double best = -1;
  constexpr int kRings = 60;
  for (int i = 0; i <= kRings; ++i) {
    const double polar = M_PI * i / kRings;
    for (int j = 0; j < 2 * kRings; ++j) {
      const double turn = M_PI * j / kRings;
      const Vec3 d(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
      best = std::max(best, d.dot(p) - support(part, d));
    }
  }
  return best;
}

double clearance(const proto::ObjectBundle& o, const Vec3& p) {
  double least = 1;
  for (const auto& part : o.part()) least = std::min(least, clearance(part, p));
  return least;
}

TEST(Builtin, AFingerEntersTheMugsCup) {
  const proto::ObjectBundle o = load("mug");
  for (const double z : {-0.03, 0.0, 0.03}) {
    for (const double x : {0.0, 0.026, -0.026}) EXPECT_GT(clearance(o, {x, 0, z}), 0.009) << x << " " << z;
  }
}

TEST(Builtin, ASixteenMillimetreFingerPassesTheMugsHandle) {
  const proto::ObjectBundle o = load("mug");
  for (const double y : {-0.02, -0.01, 0.0, 0.01, 0.02}) EXPECT_GT(clearance(o, {0.052, y, 0}), 0.008) << y;
}

TEST(Builtin, MugWallsAreThere) {
  const proto::ObjectBundle o = load("mug");
  for (int i = 0; i < 36; ++i) {
    const double a = 2 * M_PI * i / 36;
    EXPECT_LT(clearance(o, {0.039 * std::cos(a), 0.039 * std::sin(a), 0.01}), 0) << i;
  }
  EXPECT_LT(clearance(o, {0, 0, -0.045}), 0);
}

TEST(Builtin, PlatedMugStandsOnItsPlate) {
  const proto::ObjectBundle mug = load("mug"), plated = load("plated_mug");
  EXPECT_NEAR(plated.resting(0).height(), mug.resting(0).height() + 0.012, 1e-12);
  EXPECT_GE(plated.footprint_radius(), 0.075);
}

TEST(Builtin, AWrongNameSaysWhatWasMeant) {
  const Result<LoadedObject> object = load_object("cylnder", {});
  ASSERT_FALSE(object);
  EXPECT_EQ(object.error().code, ErrorCode::kNotFound);
  EXPECT_NE(object.error().message.find("did you mean 'cylinder'?"), std::string::npos)
      << object.error().message;
}

TEST(Builtin, PackedBundlesComeBackAndDamageIsSeen) {
  const Result<LoadedObject> object = load_object("mug", {});
  ASSERT_TRUE(object);
  std::string packed = pack_bundle(object->bundle);
  const Result<proto::ObjectBundle> back = unpack_object(packed, object->id);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->SerializeAsString(), object->bundle.SerializeAsString());
  EXPECT_FALSE(unpack_object(packed, std::string(64, '0')));
  EXPECT_FALSE(unpack_object("not packed", object->id));
  EXPECT_FALSE(unpack_object("", object->id));
  packed[packed.size() / 2] = static_cast<char>(packed[packed.size() / 2] ^ 1);
  EXPECT_FALSE(unpack_object(packed, object->id));
}

std::string packed_of(const std::string& bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 6));
  return packed;
}

// What is a few kilobytes to send must not be gigabytes to hold.
TEST(Builtin, SmallAssetsThatUnpackToMuchAreRefused) {
  const auto expect_refused = [](const std::string& bytes, const std::string& why) {
    const std::string packed = packed_of(bytes);
    for (const bool hand : {false, true}) {
      const std::string id = sha256_hex(bytes);
      const auto object = unpack_object(packed, id);
      const auto as_hand = unpack_hand(packed, id);
      const std::string said =
          hand ? (as_hand ? "" : as_hand.error().message) : (object ? "" : object.error().message);
      EXPECT_NE(said.find(why), std::string::npos) << (hand ? "hand: " : "object: ") << said;
    }
  };
  const auto repeated = [](const std::string& field, std::size_t times) {
    std::string bytes;
    for (std::size_t i = 0; i < times; ++i) bytes += field;
    return bytes;
  };
  expect_refused(repeated(std::string("\x12\0", 2), 200'000), "more than the 100000 values");  // part, link
  std::string nested = repeated(std::string("\x12\0", 2), 150'000);  // parts of a link
  const auto size = static_cast<std::uint32_t>(nested.size());
  std::string length;
  for (std::uint32_t left = size; left > 0; left >>= 7)
    length.push_back(static_cast<char>((left & 0x7f) | (left > 0x7f ? 0x80 : 0)));
  const std::string link = "\x12" + length + nested;
  const auto hand = unpack_hand(packed_of(link), sha256_hex(link));
  ASSERT_FALSE(hand);
  EXPECT_NE(hand.error().message.find("more than the 100000 values"), std::string::npos);
  expect_refused(repeated("\xf8\x07\x01", 200'000), "more than the 100000 values");  // unknown fields
  expect_refused(repeated("\xfb\x07\xfc\x07", 10), "not an asset of this kind");     // groups
  expect_refused(std::string("\x12\x05\0", 3), "not an asset of this kind");
  expect_refused(std::string((16 << 20) + 1, '\0'), "larger than the 16 MiB allowed");
}

TEST(Builtin, EveryBuiltInAssetFitsInAPackedOne) {
  for (const std::string& name : builtin_objects()) {
    const auto object = load_object(name, {});
    ASSERT_TRUE(object) << name;
    EXPECT_TRUE(unpack_object(pack_bundle(object->bundle), object->id)) << name;
  }
  for (const std::string& name : builtin_hands()) {
    const auto hand = load_hand(name, {});
    ASSERT_TRUE(hand) << name;
    EXPECT_TRUE(unpack_hand(pack_bundle(hand->bundle), hand->id)) << name;
  }
}

}  // namespace
}  // namespace evograsp::assets
