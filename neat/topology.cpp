#include "neat/topology.h"

#include <numeric>

namespace evograsp::neat {
namespace {

// Links between nodes that compute, by source: targets of place p are target[first[p]] .. target[first[p +
// 1]].
struct Successors {
  std::vector<std::uint32_t> first, target;
};

template <class Visit>
void each_inner_link(const Genome& genome, Visit visit) {
  const StartStructure& start = genome.start();
  for (const StartStructure::Segment& s : start.segment) {
    if (start.source[s.first + s.count - 1] < start.first_output())
      continue;  // sources ascend: inputs and bias only
    const std::uint32_t to = genome.node_place(s.target);
    for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
      if (start.source[i] >= start.first_output()) visit(genome.node_place(start.source[i]), to);
  }
  for (const LinkEnds& ends : genome.late_ends())
    if (ends.source() >= start.first_output())
      visit(genome.node_place(ends.source()), genome.node_place(ends.target()));
}

Successors successors(const Genome& genome) {
  Successors s;
  s.first.assign(genome.computed_nodes() + 2, 0);
  each_inner_link(genome, [&](std::uint32_t from, std::uint32_t) { ++s.first[from + 2]; });
  std::partial_sum(s.first.begin(), s.first.end(), s.first.begin());
  s.target.resize(s.first.back());
  each_inner_link(genome, [&](std::uint32_t from, std::uint32_t to) { s.target[s.first[from + 1]++] = to; });
  s.first.pop_back();
  return s;
}

}  // namespace

bool closes_cycle(const Genome& genome, std::uint32_t source, std::uint32_t target) {
  if (source == target) return true;
  if (source < genome.start().first_output()) return false;  // nothing leads into an input or the bias
  const std::uint32_t goal = genome.node_place(source), origin = genome.node_place(target);
  const Successors next = successors(genome);
  std::vector<std::uint8_t> seen(genome.computed_nodes(), 0);
  std::vector<std::uint32_t> open = {origin};
  seen[origin] = 1;
  while (!open.empty()) {
    const std::uint32_t place = open.back();
    open.pop_back();
    for (std::uint32_t k = next.first[place]; k < next.first[place + 1]; ++k) {
      const std::uint32_t to = next.target[k];
      if (to == goal) return true;
      if (seen[to] == 0) open.push_back(to);
      seen[to] = 1;
    }
  }
  return false;
}

bool is_acyclic(const Genome& genome) {
  const Successors next = successors(genome);
  std::vector<std::uint32_t> waiting(genome.computed_nodes(), 0);
  for (const std::uint32_t to : next.target) ++waiting[to];
  std::vector<std::uint32_t> ready;
  for (std::uint32_t p = 0; p < genome.computed_nodes(); ++p)
    if (waiting[p] == 0) ready.push_back(p);
  for (std::size_t k = 0; k < ready.size(); ++k)
    for (std::uint32_t e = next.first[ready[k]]; e < next.first[ready[k] + 1]; ++e)
      if (--waiting[next.target[e]] == 0) ready.push_back(next.target[e]);
  return ready.size() == genome.computed_nodes();
}

}  // namespace evograsp::neat
