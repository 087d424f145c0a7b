#include "cli/table.h"

#include <gtest/gtest.h>

#include <limits>

namespace evograsp::cli {
namespace {

TEST(Table, AlignsColumnsByWhatATerminalShows) {
  Table table({{"name"}, {"n", Align::kRight}});
  table.add({"größe", "7"});
  table.add({"x", "1,234"});
  EXPECT_EQ(table.text(),
            "name       n\n"
            "─────  ─────\n"
            "größe      7\n"
            "x      1,234\n");
}

TEST(Table, AStrangersNameCannotSteerTheTerminal) {
  EXPECT_EQ(printable("a\x1b[2Jb\nc\x7f"), "a?[2Jb?c?");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "?2J")
      << "C1 control sequence introducer";
  EXPECT_EQ(printable("é"), "é");
  Table table({{"name"}});
  table.add({"\x1b]0;x\a"});
  EXPECT_EQ(table.text().find('\x1b'), std::string::npos);
}

TEST(Table, MissingCellsAreEmpty) {
  Table table({{"a"}, {"b"}});
  table.add({"1"});
  EXPECT_EQ(table.text(), "a  b\n─  ─\n1\n");
}

TEST(Sparkline, SpansFromNothingToTheLargest) {
  EXPECT_EQ(sparkline(std::vector<double>{0, 0.5, 1}, 10), "▁▅█");
  EXPECT_EQ(sparkline(std::vector<double>{-1, 1}, 10), "▁█");
  EXPECT_EQ(sparkline(std::vector<double>{0, 0}, 10), "▁▁");
  EXPECT_EQ(sparkline(std::vector<double>{}, 10), "");
  EXPECT_EQ(sparkline(std::vector<double>{std::numeric_limits<double>::quiet_NaN(), 1}, 10), " █");
}

TEST(Sparkline, KeepsTheLastOfMoreThanFit) {
  std::vector<double> values(1000, 0.0);
  values.back() = 1;
  EXPECT_EQ(sparkline(values, 4), "▁▁▁█");
  EXPECT_EQ(sparkline(values, 1), "█");
}

TEST(Fixed, SaysWhatIsNoNumber) {
  EXPECT_EQ(fixed(0.81254, 3), "0.813");
  EXPECT_EQ(fixed(std::numeric_limits<double>::infinity()), "-");
  EXPECT_LT(fixed(1e300).size(), 20u);
}

}  // namespace
}  // namespace evograsp::cli
