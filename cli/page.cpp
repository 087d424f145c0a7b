#include "cli/page.h"

#include <algorithm>
#include <cstdint>
#include <sstream>

namespace evograsp::cli {
namespace {

std::string joined(const std::vector<std::string>& lines, const std::string& separator) {
  std::string out;
  for (const std::string& line : lines) out += (out.empty() ? "" : separator) + line;
  return out;
}

// A bar would end the cell, a line break the row.
std::string markdown_cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? "\\|" : c == '\n' ? " " : std::string(1, c);
  return out;
}

struct MarkdownWriter {
  std::string out;

  void operator()(const PageHeading& h) {
    out += std::string(static_cast<std::size_t>(h.level), '#') + " " + h.text + "\n\n";
  }
  void operator()(const PageText& t) { out += t.text + "\n\n"; }
  void operator()(const PageList& l) {
    for (const std::string& item : l.items) out += "- " + item + "\n";
    out += "\n";
  }
  void operator()(const PageTable& t) {
    const auto line = [this](const std::vector<std::string>& cells) {
      out += "|";
      for (const std::string& cell : cells) out += " " + markdown_cell(cell) + " |";
      out += "\n";
    };
    line(t.columns);
    out += "|";
    for (std::size_t i = 0; i < t.columns.size(); ++i) out += i < t.words ? " --- |" : " ---: |";
    out += "\n";
    for (const auto& row : t.rows) line(row);
    out += "\n";
  }
  void operator()(const PageFigure& f) {
    out += "![" + f.alt + "](" + f.file + ")\n\n";
    if (!f.caption.empty()) out += f.caption + "\n\n";
  }
  void operator()(const PageCode& c) {
    std::istringstream lines(c.text);
    for (std::string line; std::getline(lines, line);) out += line.empty() ? "\n" : "    " + line + "\n";
    out += "\n";
  }
};

// Text with what stands in backticks as <code>.
std::string inline_html(const std::string& text) {
  std::string out;
  bool code = false;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find('`', from), text.size());
    out += html_escaped(std::string_view(text).substr(from, end - from));
    if (end < text.size()) out += (code = !code) ? "<code>" : "</code>";
    from = end + 1;
  }
  return code ? out + "</code>" : out;
}

struct HtmlWriter {
  std::string out;

  void operator()(const PageHeading& h) {
    const std::string tag = "h" + std::to_string(h.level);
    out += "<" + tag + ">" + inline_html(h.text) + "</" + tag + ">\n";
  }
  void operator()(const PageText& t) { out += "<p>" + inline_html(t.text) + "</p>\n"; }
  void operator()(const PageList& l) {
    out += "<ul>\n";
    for (const std::string& item : l.items) out += "<li>" + inline_html(item) + "</li>\n";
    out += "</ul>\n";
  }
  void operator()(const PageTable& t) {
    const auto line = [this, &t](const std::vector<std::string>& cells, const std::string& tag) {
      out += "<tr>";
      for (std::size_t i = 0; i < cells.size(); ++i)
        out += "<" + tag + (i < t.words ? " class=\"w\">" : ">") + inline_html(cells[i]) + "</" + tag + ">";
      out += "</tr>\n";
    };
    out += "<div class=\"table\"><table>\n";
    line(t.columns, "th");
    for (const auto& row : t.rows) line(row, "td");
    out += "</table></div>\n";
  }
  // As a picture of its own: the outlines of letters in two drawings bear the same names.
  void operator()(const PageFigure& f) {
    out += "<figure><img alt=\"" + html_escaped(f.alt) + "\" src=\"data:image/svg+xml;base64," +
           base64(f.svg) + "\">";
    if (!f.caption.empty()) out += "<figcaption>" + inline_html(f.caption) + "</figcaption>";
    out += "</figure>\n";
  }
  void operator()(const PageCode& c) { out += "<pre>" + html_escaped(c.text) + "</pre>\n"; }
};

}  // namespace

const char kPageStyle[] =
    "body{font:16px/1.5 system-ui,sans-serif;color:#20242b;max-width:960px;margin:2rem auto;padding:0 1rem}"
    "h1{font-size:1.5rem}h2{font-size:1.1rem;margin-top:2rem}table{border-collapse:collapse}"
    "td,th{padding:.2rem .9rem .2rem 0;text-align:right;font-variant-numeric:tabular-nums}"
    "td:first-child,th:first-child,.facts td,td.w,th.w{text-align:left}th{border-bottom:1px solid "
    "#ccc;font-weight:600}"
    "svg,img{max-width:100%;height:auto}pre{background:#f5f6f8;padding:1rem;overflow:auto;font-size:.85rem}"
    "code{background:#f5f6f8;padding:0 .2rem}figure{margin:1.5rem 0}figcaption{color:#555;font-size:.9rem}"
    ".table{overflow-x:auto}";

std::string to_markdown(const Page& page) {
  MarkdownWriter writer{"# " + page.title + "\n\n"};
  for (const PagePart& part : page.parts) std::visit(writer, part);
  std::string& out = writer.out;
  while (out.ends_with("\n\n")) out.pop_back();
  return out;
}

std::string to_html(const Page& page) {
  HtmlWriter writer{
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>" +
      html_escaped(page.title) + " - evograsp</title>\n<style>" + kPageStyle + "</style></head><body>\n<h1>" +
      inline_html(page.title) + "</h1>\n"};
  for (const PagePart& part : page.parts) std::visit(writer, part);
  return writer.out + "</body></html>\n";
}

std::vector<PagePart> parse_markdown(std::string_view text) {
  std::vector<PagePart> parts;
  std::vector<std::string> block;
  const auto flush = [&] {
    if (block.empty()) return;
    const std::string& first = block.front();
    const std::size_t level = std::min(first.find_first_not_of('#'), first.size());
    if (level > 0 && level <= 4 && level < first.size() && first[level] == ' ') {
      parts.push_back(PageHeading{static_cast<int>(level), first.substr(level + 1)});
      block.erase(block.begin());
      if (!block.empty()) parts.push_back(PageText{joined(block, " ")});
    } else if (std::ranges::all_of(block, [](const std::string& line) { return line.starts_with("    "); })) {
      std::string code;
      for (const std::string& line : block) code += line.substr(4) + "\n";
      parts.push_back(PageCode{code});
    } else if (first.starts_with("- ")) {
      PageList list;
      for (const std::string& line : block) {
        if (line.starts_with("- ")) {
          list.items.push_back(line.substr(2));
        } else {
          list.items.back() += " " + line.substr(std::min(line.find_first_not_of(' '), line.size()));
        }
      }
      parts.push_back(std::move(list));
    } else {
      parts.push_back(PageText{joined(block, " ")});
    }
    block.clear();
  };
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      flush();
    } else {
      block.push_back(line);
    }
  }
  flush();
  return parts;
}

std::string html_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    out += c == '<'   ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '&' ? "&amp;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  }
  return out;
}

std::string base64(std::string_view data) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < data.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, data.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (k < left ? static_cast<unsigned char>(data[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= left ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace evograsp::cli
