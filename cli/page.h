// A page of text, tables and pictures, written as Markdown (pictures beside it) and as one HTML file that
// needs nothing else.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace evograsp::cli {

struct PageHeading {
  int level = 2;
  std::string text;
};
struct PageText {  // a paragraph, with `code` in it
  std::string text;
};
struct PageList {
  std::vector<std::string> items;
};
struct PageTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::size_t words = 1;  // so many columns from the left hold words; numbers stand to the right
};
struct PageFigure {
  std::string file;  // beside the Markdown page
  std::string svg;   // inside the HTML page
  std::string alt, caption;
};
struct PageCode {
  std::string text;
};
using PagePart = std::variant<PageHeading, PageText, PageList, PageTable, PageFigure, PageCode>;

struct Page {
  std::string title;
  std::vector<PagePart> parts;
};

std::string to_markdown(const Page& page);
std::string to_html(const Page& page);

// Headings, paragraphs, lists of "- " and indented code of a Markdown text; anything else is a paragraph.
std::vector<PagePart> parse_markdown(std::string_view text);

// Pieces of HTML pages.
extern const char kPageStyle[];
std::string html_escaped(std::string_view text);
std::string base64(std::string_view data);

}  // namespace evograsp::cli
