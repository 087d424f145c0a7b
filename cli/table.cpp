#include "cli/table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace evograsp::cli {
namespace {

std::string padded(const std::string& cell, std::size_t width, Align align) {
  const std::string blank(width - std::min(width, display_width(cell)), ' ');
  return align == Align::kRight ? blank + cell : cell + blank;
}

std::string trimmed(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

}  // namespace

void Table::add(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  for (std::string& cell : cells) cell = printable(cell);
  rows_.push_back(std::move(cells));
}

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    std::size_t width = display_width(columns_[i].name);
    for (const auto& row : rows_) width = std::max(width, display_width(row[i]));
    widths.push_back(width);
  }
  const auto line = [&](auto cell) {
    std::string out;
    for (std::size_t i = 0; i < columns_.size(); ++i)
      out += (i == 0 ? "" : "  ") + padded(cell(i), widths[i], columns_[i].align);
    return trimmed(out) + "\n";
  };
  std::string out = line([&](std::size_t i) { return columns_[i].name; });
  std::string rule;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (i > 0) rule += "  ";
    for (std::size_t k = 0; k < widths[i]; ++k) rule += "─";
  }
  out += rule + "\n";
  for (const auto& row : rows_) out += line([&](std::size_t i) { return row[i]; });
  return out;
}

std::string sparkline(std::span<const double> values, std::size_t width) {
  static const char* kBars[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  double low = 0, high = 0;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  const std::size_t count = std::min(width, values.size());
  std::string out;
  for (std::size_t i = 0; i < count; ++i) {
    // Evenly spread over all values, the last one always among them.
    const std::size_t at = count == 1 ? values.size() - 1 : i * (values.size() - 1) / (count - 1);
    const double v = values[at];
    const double part = high > low ? (v - low) / (high - low) : 0;
    out += std::isfinite(v) ? kBars[std::clamp(static_cast<int>(part * 8), 0, 7)] : " ";
  }
  return out;
}

std::string fixed(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  char text[64];
  const int size = std::snprintf(text, sizeof text, "%.*f", digits, value);
  if (size < static_cast<int>(sizeof text)) return text;
  std::snprintf(text, sizeof text, "%.*e", digits, value);
  return text;
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    // U+0080 to U+009F are control characters too: two bytes in UTF-8.
    const bool c1 =
        c == 0xc2 && i + 1 < text.size() && (static_cast<unsigned char>(text[i + 1]) & 0xe0) == 0x80;
    if (c1) ++i;
    out.push_back(c < 0x20 || c == 0x7f || c1 ? '?' : text[i]);
  }
  return out;
}

std::size_t display_width(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

}  // namespace evograsp::cli
