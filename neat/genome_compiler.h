// From one genome to one network, gene by gene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/network.h"
#include "neat/genome.h"

namespace evograsp::neat {

// Turns genomes into networks: enabled links only, nodes in evaluation order, hidden nodes that reach no
// output left out (unless recurrent). Keeps its working storage from genome to genome. Linear in the links.
// Not thread-safe.
class GenomeCompiler {
 public:
  explicit GenomeCompiler(bool recurrent) : recurrent_(recurrent) {}

  // The network's columns; they stay valid until the next call. The genome must hold its laws (check() in
  // genome.h). `only`: with this output alone; -1: all.
  NetworkColumns columns(const Genome& genome, int only = -1);

 private:
  void count_links(const Genome& genome);
  void gather_edges(const Genome& genome);
  void mark_live(const Genome& genome, int only);
  void order_nodes(const Genome& genome, int only);
  void copy_enabled(const Genome& genome, const StartStructure::Segment& s, std::uint32_t& to);
  void fill_links(const Genome& genome);
  std::uint32_t value_of(const Genome& genome, std::uint32_t node) const;
  void append(std::uint32_t place, std::uint32_t source, float weight);
  void sort_sources();
  void sort_many(std::uint32_t begin, std::uint32_t sorted, std::uint32_t end);

  bool recurrent_;
  // By place (Genome::node_place).
  std::vector<std::uint32_t> count_, position_, waiting_, edge_first_;
  std::vector<std::uint8_t> live_;
  std::vector<std::uint32_t> edge_from_, edge_to_, edge_by_source_;  // enabled links between computing nodes
  std::vector<std::uint32_t> order_;                                 // places in evaluation order
  std::vector<std::uint32_t> end_;                                   // where a place's next link goes
  std::vector<std::uint32_t> sorted_;                                // its links ascend up to here
  // The network's columns.
  std::vector<std::uint8_t> activation_;
  std::vector<float> bias_, weight_;
  std::vector<std::uint32_t> first_link_, source_, output_node_;
  std::vector<std::pair<std::uint32_t, float>> sorting_;
};

}  // namespace evograsp::neat
