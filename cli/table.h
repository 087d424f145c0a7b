// Aligned columns and little pictures in characters.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace evograsp::cli {

enum class Align { kLeft, kRight };

// A table as text: a header, a rule, rows; columns two spaces apart. Cells are cleaned with printable().
class Table {
 public:
  struct Column {
    std::string name;
    Align align = Align::kLeft;
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}
  // One cell a column; missing ones are empty, more are dropped.
  void add(std::vector<std::string> cells);
  bool empty() const { return rows_.empty(); }
  std::string text() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

// One character a value, from the smallest to the largest of 0 and the values; not a number: a blank. More
// values than `width` are thinned out, the last one kept.
std::string sparkline(std::span<const double> values, std::size_t width);

// "0.8125" with so many digits after the point; "-" for what is not a number.
std::string fixed(double value, int digits = 4);

// Control characters replaced: a name from a stranger must not steer the terminal.
std::string printable(std::string_view text);

// Characters as a terminal counts them, for UTF-8 of single-width characters.
std::size_t display_width(std::string_view text);

}  // namespace evograsp::cli
