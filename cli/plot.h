// The fitness of a run over its generations: as a figure, and in characters for a terminal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/chart.h"

namespace evograsp::cli {

struct FitnessPoint {
  std::uint32_t generation = 0;
  double best = 0, mean = 0;
  std::uint32_t species = 0;
};

// The vertical axis ends at 1, or at a round number above the largest value.
struct FitnessPlot {
  std::string title;
  std::vector<FitnessPoint> points;  // in the order of generations
};

Figure figure_of(const FitnessPlot& plot);
// `columns` x `rows` characters and the axes. Best as dots of Braille, mean as light ones.
std::string to_text(const FitnessPlot& plot, int columns = 64, int rows = 13);
// Columns for a plot whose axis and labels shall fit, too.
int plot_columns(int terminal_columns);

}  // namespace evograsp::cli
