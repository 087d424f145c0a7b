// A plane of cells, each with a value or empty: as a picture and in characters.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace evograsp::cli {

struct HeatAxis {
  std::string label;
  double low = 0, high = 1;  // what the bins part evenly
  int bins = 1;
};

struct HeatMap {
  std::string title;
  std::string value_label;
  HeatAxis x, y;
  std::vector<double> value;  // [x + y * x.bins]; not a number: empty
};

// Rows from the highest y down; each cell's value in digits, "." where it is empty.
std::string to_text(const HeatMap& map);
Status write_png(const HeatMap& map, const std::filesystem::path& path);
Result<std::string> to_svg(const HeatMap& map);

}  // namespace evograsp::cli
