// Hands from strangers, URDF and hand files: each gives an error that names the file and the reason.
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>

#include "assets/assets.h"
#include "assets/plain_xml.h"
#include "assets/urdf.h"
#include "tests/assets/files.h"

namespace evograsp::assets {
namespace {

using testing::binary_stl_of;
using testing::box_mesh;
using testing::TemporaryFolder;

class HostileHands : public ::testing::Test {
 protected:
  void expect_hand_refused(const std::string& name, const std::string& text, const std::string& reason) {
    const std::string path = folder_.write(name, text);
    const Result<LoadedHand> hand = load_hand(path, {});
    ASSERT_FALSE(hand) << name << " was accepted";
    EXPECT_NE(hand.error().message.find(name.substr(0, name.find('.'))), std::string::npos)
        << hand.error().message;
    EXPECT_NE(hand.error().message.find(reason), std::string::npos) << hand.error().message;
  }
  TemporaryFolder folder_;
};

TEST_F(HostileHands, UrdfsThatAreNoHands) {
  expect_hand_refused("junk.urdf", "not xml at all", "not a usable URDF");
  expect_hand_refused("empty_robot.urdf", "<robot name=\"x\"></robot>", "not a usable URDF");
  expect_hand_refused("arm.urdf",
                      R"(<robot name="arm"><link name="a"/><link name="b"/><joint name="j" type="revolute">
<parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>)",
                      "not a hand");
  std::string deep = "<robot name=\"x\">";
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  expect_hand_refused("deep.urdf", deep, "nested deeper");
  expect_hand_refused("nolimit.urdf",
                      R"(<robot name="x"><link name="a"/><link name="b"/><joint name="j" type="revolute">
<parent link="a"/><child link="b"/></joint></robot>)",
                      "");
}

// Ways to make a counter of tags and a parser disagree about what is open.
TEST_F(HostileHands, UrdfsThatHideTheirDepthAreRefused) {
  std::string deep = "<robot name=\"r\">", closings;
  for (int i = 0; i < 60000; ++i) deep += "<a>", closings += "</a>";
  const std::string both = deep + closings + "</robot>";
  expect_hand_refused("quote.urdf", "<?xml version=\"1.0\" ' ?>" + both, "nested deeper");
  expect_hand_refused("doctype.urdf", "<!DOCTYPE ' >" + both, "nested deeper");
  expect_hand_refused("mark.urdf", "\xEF\xBB\xBF" + both, "nested deeper");
  expect_hand_refused("closed.urdf", closings + deep, "line 1: closes an element that is not open");
  expect_hand_refused("cdata.urdf", "<robot name=\"r\"><![CDATA[ ' ]]>" + deep, "'<' does not begin");
  expect_hand_refused("within.urdf", "<robot name=\"r\">\n<!DOCTYPE ' >" + deep,
                      "line 2: '<' does not begin");
  expect_hand_refused("entity.urdf", "<!DOCTYPE r [<!ENTITY a \"b\">]>" + deep, "with definitions");
  expect_hand_refused("half.urdf", "<robot name=\"r\"><!--", "a comment that does not end");
  std::string hidden = "<robot name=\"r\">";  // "<!-->" is the beginning of a comment, not all of it
  for (int i = 0; i < 60000; ++i) hidden += "<a><!--></a>-->";
  expect_hand_refused("comment.urdf", hidden, "nested deeper");
  std::string leads = "<?xml version=\"1.0\"?><robot name=\"r\">";  // a lead byte swallows what follows it
  for (int i = 0; i < 60000; ++i) leads += "<a>\xF0</a>";
  expect_hand_refused("utf8.urdf", leads + "</robot>", "more than 20000 elements");
}

TEST_F(HostileHands, UrdfsThatAreLongAreReadOrRefusedSoon) {
  std::string many = "<robot name=\"r\"><a ", text = "<robot name=\"r\">";
  for (int i = 0; i < 200000; ++i) many += "b" + std::to_string(i) + "=\"\" ";
  while (text.size() < kMaxUrdf - 100) text += "some text &#1; &amp; ";
  std::string links = "<robot name=\"r\">", chain = "<link name=\"l0\"/>";
  for (int i = 0; i < kMaxXmlElements - 5; ++i) links += "<link name=\"l" + std::to_string(i) + "\"/>";
  for (int i = 1; i < 3900; ++i) {
    const std::string n = std::to_string(i), parent = std::to_string(i - 1);
    chain += "<link name=\"l" + n + "\"/><joint name=\"j" + n + "\" type=\"fixed\"><parent link=\"l" +
             parent + "\"/><child link=\"l" + n + "\"/></joint>";
  }
  const auto processor_seconds = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  const double before = processor_seconds();
  expect_hand_refused("attributes.urdf", many + "/></robot>", "more than 64 attributes");
  expect_hand_refused("text.urdf", text + "</robot>", "not a usable URDF");
  expect_hand_refused("links.urdf", links + "</robot>", "");
  expect_hand_refused("chain.urdf", "<robot name=\"r\">" + chain + "</robot>", "more than 512 links");
  EXPECT_LT(processor_seconds() - before, 10) << "refused, but slowly";
}

const char kTwoJaws[] =
    R"(<robot name="jaws"><link name="p"><collision><geometry><box size="0.1 0.1 0.02"/></geometry></collision></link>
<link name="l"><collision><geometry><box size="0.02 0.01 0.06"/></geometry></collision></link>
<link name="r"><collision><geometry><mesh filename="%MESH%"/></geometry></collision></link>
<joint name="jl" type="prismatic"><parent link="p"/><child link="l"/><origin xyz="0 0.05 0.03"/><axis xyz="0 -1 0"/>
<limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
<joint name="jr" type="prismatic"><parent link="p"/><child link="r"/><origin xyz="0 -0.05 0.03"/><axis xyz="0 1 0"/>
<limit lower="0" upper="0.04" effort="1" velocity="1"/><mimic joint="jl" multiplier="0.5"/></joint></robot>)";

std::string jaws_with(const std::string& mesh) {
  std::string text = kTwoJaws;
  text.replace(text.find("%MESH%"), 6, mesh);
  return text;
}

TEST_F(HostileHands, HandMeshesOutsideTheirPackageAreLeftOutWithAWarning) {
  for (const char* mesh :
       {"package://../../etc/passwd", "package://a/../../x.stl", "http://host/x.stl", "missing.stl"}) {
    const Result<LoadedHand> hand = load_hand(folder_.write("jaws.urdf", jaws_with(mesh)), {});
    ASSERT_TRUE(hand) << hand.error().message;
    const auto& w = hand->warnings;
    EXPECT_TRUE(std::any_of(w.begin(), w.end(), [](const auto& s) {
      return s.find("link 'r'") != std::string::npos;
    })) << mesh;
  }
}

TEST_F(HostileHands, MimicJointsFollowTheirLeadersMotorAndMeshesBecomeHulls) {
  folder_.write("meshes/jaw.stl", binary_stl_of(box_mesh({10, 5, 30})));
  std::string text = jaws_with("package://meshes/jaw.stl\" scale=\"0.001 0.001 0.001");
  const Result<LoadedHand> hand = load_hand(folder_.write("jaws.urdf", text), {});
  ASSERT_TRUE(hand) << hand.error().message;
  ASSERT_EQ(hand->bundle.motor_size(), 1);
  ASSERT_EQ(hand->bundle.motor(0).joint_size(), 2);
  EXPECT_DOUBLE_EQ(hand->bundle.motor(0).ratio(0), 1);
  EXPECT_DOUBLE_EQ(hand->bundle.motor(0).ratio(1), 0.5);
  ASSERT_EQ(hand->bundle.link(2).part_size(), 1);
  EXPECT_EQ(hand->bundle.link(2).part(0).hull().xyz_size(), 24);
}

TEST_F(HostileHands, HandFilesSayWhichFieldIsWrong) {
  folder_.write("jaws.urdf", jaws_with("none.stl"));
  const std::string good = "urdf: \"jaws.urdf\" palm_link: \"p\" thumb_tip_link: \"r\" ";
  expect_hand_refused("palm.txtpb", "urdf: \"jaws.urdf\" palm_link: \"q\" thumb_tip_link: \"r\"",
                      "palm_link");
  expect_hand_refused("axis.txtpb", good + "approach_axis { }", "approach_axis");
  expect_hand_refused("preset.txtpb", good + "preset { joint: \"jl\" value: 3 }", "outside the limits");
  expect_hand_refused("motor.txtpb", good + "motor { name: \"m\" joint { joint: \"zz\" } }", "zz");
  expect_hand_refused(
      "twice.txtpb",
      good + "motor { name: \"m\" joint { joint: \"jl\" } } motor { name: \"n\" joint { joint: \"jl\" } }",
      "twice");
  expect_hand_refused("thumb.txtpb", "urdf: \"jaws.urdf\" palm_link: \"p\" thumb_tip_link: \"t\"",
                      "thumb_tip_link");
  expect_hand_refused("urdf.txtpb", "palm_link: \"p\"", "urdf");
}

}  // namespace
}  // namespace evograsp::assets
