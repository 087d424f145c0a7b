// The kinds of grasp that a run has found (proto::ArchiveConfig).
//
// A map of elites (Mouret and Clune 2015, "Illuminating search spaces by mapping elites"): two measures of
// what a genome does, its behaviour, span a plane of cells, and each cell keeps the fittest genome of its
// kind. Fitness here is noisy, because each generation has trials of its own: an elite that is judged again
// keeps the mean over all its judgements of fitness and of behaviour, and moves when its mean leaves the
// cell, so that luck wears off.
//
// And a memory of what was novel (Lehman and Stanley 2011, "Abandoning objectives: evolution through the
// search for novelty alone", section 4): novelty is the mean distance to the nearest neighbours among the
// generation and the memory.
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "common/result.h"
#include "neat/genome.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

// What a genome does, each number from 0 to 1. Not finite: nothing can be said of it.
struct Behaviour {
  double x = std::numeric_limits<double>::quiet_NaN(), y = x;
  bool known() const;
};

struct Elite {
  Genome genome;
  std::uint32_t generation = 0;  // that brought it onto the map
  std::uint32_t judged = 0;      // so often
  double fitness_sum = 0, x_sum = 0, y_sum = 0;

  double fitness() const { return fitness_sum / judged; }
  Behaviour behaviour() const { return {x_sum / judged, y_sum / judged}; }
};

// Not thread-safe.
class Archive {
 public:
  explicit Archive(const proto::ArchiveConfig& config);

  std::uint32_t columns() const { return columns_; }  // bins of x
  std::uint32_t rows() const { return rows_; }        // bins of y
  std::uint32_t cells() const { return columns_ * rows_; }
  std::uint32_t cell_of(const Behaviour& behaviour) const;  // x + y * columns(); of a known one

  // What genomes [i] of a generation achieved and did. First those that are elites already are judged again;
  // then the others are held against their cells' elites, in the order given: the fitter has the cell, of
  // equals the older. Fitness or behaviour that is not finite changes nothing.
  void add(std::uint32_t generation, std::span<const Genome> genomes, std::span<const double> fitness,
           std::span<const Behaviour> behaviour);
  const std::map<std::uint32_t, Elite>& elites() const { return elites_; }  // by cell
  // Cells that the last add() changed or emptied; after restoring, all that are filled as well.
  const std::set<std::uint32_t>& changed() const { return changed_; }

  // Mean distance of each to its config.neighbours nearest among the others and the memory; 0 for what is not
  // known. The plane is a unit square; a whole circle of headings (YAW) closes.
  std::vector<double> novelty(std::span<const Behaviour> behaviour) const;
  // Keeps the config.remembered most novel; of equals the first.
  void remember(std::span<const Behaviour> behaviour, std::span<const double> novelty);
  const std::deque<Behaviour>& memory() const { return memory_; }

  // Of stored state; kInvalid for what no run can have left.
  Status restore_elite(std::uint32_t cell, Elite elite);
  Status restore_memory(Behaviour behaviour);

 private:
  void judge_again(std::span<const Genome> genomes, std::span<const double> fitness,
                   std::span<const Behaviour> behaviour, std::vector<bool>& known);
  void hold_against(Elite elite);
  double distance(const Behaviour& a, const Behaviour& b) const;

  std::uint32_t columns_, rows_, neighbours_, remembered_, memory_size_;
  bool circle_x_, circle_y_;
  std::map<std::uint32_t, Elite> elites_;
  std::set<std::uint32_t> changed_;
  bool restored_ = false;
  std::deque<Behaviour> memory_;
};

// (1 - weight) fitness + weight novelty, each taken from 0 (the least) to 1 (the most of the generation).
// Weighted sums: Cuccu and Gomez 2011, "When novelty is not enough". Not finite fitness stays so.
std::vector<double> selection_scores(std::span<const double> fitness, std::span<const double> novelty,
                                     double weight);

}  // namespace evograsp::neat
