// Heat maps: what their characters and their drawing say.
#include "cli/heat_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace evograsp::cli {
namespace {

HeatMap small() {
  const double none = std::nan("");
  return {.title = "Kinds <of> grasp",
          .value_label = "fitness",
          .x = {"pitch, degrees", 0, 90, 3},
          .y = {"height, m", -0.1, 0.1, 2},
          .value = {0.5, none, 0.25, none, none, 1.0}};
}

TEST(HeatMap, InCharactersTheHighestRowComesFirst) {
  EXPECT_EQ(to_text(small()),
            "height, m\n"
            " 0.00 |    .    . 1.00\n"
            "-0.10 | 0.50    . 0.25\n"
            "      +---------------\n"
            "           0   30   60  pitch, degrees\n");
}

TEST(HeatMap, LargeValuesLoseTheirFraction) {
  HeatMap map = small();
  for (double& v : map.value) v *= 12345;
  EXPECT_THAT(to_text(map), ::testing::HasSubstr("12345"));
  EXPECT_THAT(to_text(map), ::testing::Not(::testing::HasSubstr("12345.")));
}

TEST(HeatMap, OneCellOfNothingIsDrawnAsWell) {
  const HeatMap map{.title = "", .value_label = "", .x = {"", 0, 1, 1}, .y = {"", 0, 1, 1}, .value = {}};
  EXPECT_THAT(to_text(map), ::testing::HasSubstr(" ."));
  EXPECT_TRUE(to_svg(map));
}

// Fitter is darker, and every cell has its place.
TEST(HeatMap, AsSvgEachCellIsARectangle) {
  const auto svg = to_svg(small());
  ASSERT_TRUE(svg) << svg.error().message;
  EXPECT_TRUE(svg->starts_with("<svg"));
  std::size_t rectangles = 0;
  for (std::size_t at = svg->find("fill-opacity"); at != std::string::npos;
       at = svg->find("fill-opacity", at + 1))
    ++rectangles;
  EXPECT_GE(rectangles, 6U) << *svg;
  HeatMap darker = small();
  darker.value[1] = 0.9;
  EXPECT_NE(*to_svg(darker), *svg);
}

TEST(HeatMap, APictureThatCannotBeWrittenIsAnError) {
  EXPECT_FALSE(write_png(small(), "/nowhere/at/all.png"));
}

}  // namespace
}  // namespace evograsp::cli
