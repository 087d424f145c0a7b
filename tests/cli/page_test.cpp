// Pages: the same parts as Markdown and as HTML.
#include "cli/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace evograsp::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Page example() {
  Page page{"A & B", {}};
  page.parts = {PageHeading{2, "Success"}, PageText{"Run `a < b` twice."},
                PageTable{{"object", "success"}, {{"a|b", "<1 %"}}, 1},
                PageFigure{"p.svg", "<svg/>", "plot", "below"}, PageCode{"evograsp experiment lift\n"}};
  return page;
}

TEST(Page, ReadsAsMarkdown) {
  EXPECT_EQ(to_markdown(example()),
            "# A & B\n\n## Success\n\nRun `a < b` twice.\n\n| object | success |\n| --- | ---: |\n| a\\|b | "
            "<1 % |\n\n"
            "![plot](p.svg)\n\nbelow\n\n    evograsp experiment lift\n");
}

TEST(Page, ReadsAsHtmlThatNeedsNothingElse) {
  const std::string html = to_html(example());
  EXPECT_THAT(html, HasSubstr("<h1>A &amp; B</h1>"));
  EXPECT_THAT(html, HasSubstr("<code>a &lt; b</code>"));
  EXPECT_THAT(html, HasSubstr("<td class=\"w\">a|b</td><td>&lt;1 %</td>"));
  EXPECT_THAT(html, HasSubstr("data:image/svg+xml;base64,PHN2Zy8+"));
  for (const char* elsewhere : {"src=\"http", "href=", "<script", "@import"})
    EXPECT_THAT(html, Not(HasSubstr(elsewhere)));
}

TEST(Markdown, IsTakenApartAndPutTogetherAgain) {
  const std::string text =
      "## Why\n\nTwo lines\nof one paragraph.\n\n- first\n  goes on\n- second\n\n    code\n    more\n";
  Page page{"t", parse_markdown(text)};
  EXPECT_EQ(
      to_markdown(page),
      "# t\n\n## Why\n\nTwo lines of one paragraph.\n\n- first goes on\n- second\n\n    code\n    more\n");
}

TEST(Base64, HasPaddingAtEachLength) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace evograsp::cli
