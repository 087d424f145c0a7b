#include "neat/genome_compiler.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <tuple>

namespace evograsp::neat {
namespace {

std::uint32_t count_enabled(std::span<const std::uint64_t> flags, std::uint32_t first, std::uint32_t count) {
  std::uint32_t ones = 0;
  for (std::uint32_t i = first; i < first + count;) {
    const std::uint32_t shift = i % 64, take = std::min(64 - shift, first + count - i);
    const std::uint64_t mask = take == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << take) - 1;
    ones += static_cast<std::uint32_t>(std::popcount(flags[i / 64] >> shift & mask));
    i += take;
  }
  return ones;
}

bool has_inner_source(const StartStructure& start, const StartStructure::Segment& s) {
  return start.source[s.first + s.count - 1] >= start.first_output();  // sources ascend
}

}  // namespace

void GenomeCompiler::count_links(const Genome& genome) {
  count_.assign(genome.computed_nodes(), 0);
  for (const StartStructure::Segment& s : genome.start().segment)
    count_[genome.node_place(s.target)] += count_enabled(genome.flags(), s.first, s.count);
  const auto ends = genome.late_ends();
  for (std::uint32_t k = 0; k < ends.size(); ++k)
    if (genome.enabled(genome.start_links() + k)) ++count_[genome.node_place(ends[k].target())];
}

// Enabled links between nodes that compute, then sorted by source.
void GenomeCompiler::gather_edges(const Genome& genome) {
  const StartStructure& start = genome.start();
  edge_from_.clear();
  edge_to_.clear();
  const auto add = [&](std::uint32_t link, std::uint32_t source, std::uint32_t to) {
    if (source < start.first_output() || !genome.enabled(link)) return;
    edge_from_.push_back(genome.node_place(source));
    edge_to_.push_back(to);
  };
  for (const StartStructure::Segment& s : start.segment) {
    if (!has_inner_source(start, s)) continue;
    const std::uint32_t to = genome.node_place(s.target);
    for (std::uint32_t i = s.first; i < s.first + s.count; ++i) add(i, start.source[i], to);
  }
  const auto ends = genome.late_ends();
  for (std::uint32_t k = 0; k < ends.size(); ++k)
    if (ends[k].source() >= start.first_output())
      add(start.links() + k, ends[k].source(), genome.node_place(ends[k].target()));

  edge_first_.assign(genome.computed_nodes() + 2, 0);
  for (const std::uint32_t from : edge_from_) ++edge_first_[from + 2];
  std::partial_sum(edge_first_.begin(), edge_first_.end(), edge_first_.begin());
  edge_by_source_.resize(edge_to_.size());
  for (std::size_t e = 0; e < edge_to_.size(); ++e)
    edge_by_source_[edge_first_[edge_from_[e] + 1]++] = edge_to_[e];
}

// Kahn's algorithm; then hidden nodes before outputs where the links allow it.
void GenomeCompiler::order_nodes(const Genome& genome, int only) {
  const std::uint32_t nodes = genome.computed_nodes(), outputs = genome.outputs();
  order_.clear();
  if (recurrent_) {
    for (std::uint32_t p = outputs; p < nodes; ++p) order_.push_back(p);
    for (std::uint32_t p = 0; p < outputs; ++p) order_.push_back(p);
  } else {
    waiting_.assign(nodes, 0);
    for (const std::uint32_t to : edge_to_) ++waiting_[to];
    for (std::uint32_t p = 0; p < nodes; ++p)
      if (waiting_[p] == 0) order_.push_back(p);
    for (std::size_t k = 0; k < order_.size(); ++k)
      for (std::uint32_t e = edge_first_[order_[k]]; e < edge_first_[order_[k] + 1]; ++e)
        if (--waiting_[edge_by_source_[e]] == 0) order_.push_back(edge_by_source_[e]);
  }
  mark_live(genome, only);
  if (recurrent_ && only < 0) std::fill(live_.begin(), live_.end(), std::uint8_t{1});
  std::erase_if(order_, [&](std::uint32_t p) { return live_[p] == 0; });
  if (!recurrent_ && edge_first_[outputs] == 0) {  // no output feeds another node
    std::erase_if(order_, [&](std::uint32_t p) { return p < outputs; });
    for (std::uint32_t p = 0; p < outputs; ++p)
      if (live_[p] != 0) order_.push_back(p);
  }
}

// Nodes that reach a wanted output; order_ holds all nodes, successors late in it.
void GenomeCompiler::mark_live(const Genome& genome, int only) {
  live_.assign(genome.computed_nodes(), 0);
  for (std::uint32_t o = 0; o < genome.outputs(); ++o) live_[o] = only < 0 || only == static_cast<int>(o);
  // One pass backwards settles a feed-forward network; a recurrent one may need more.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t k = order_.size(); k-- > 0;) {
      const std::uint32_t p = order_[k];
      if (live_[p] != 0) continue;
      for (std::uint32_t e = edge_first_[p]; e < edge_first_[p + 1]; ++e)
        live_[p] |= live_[edge_by_source_[e]];
      changed |= live_[p] != 0;
    }
  }
}

std::uint32_t GenomeCompiler::value_of(const Genome& genome, std::uint32_t node) const {
  if (node <= genome.bias_node()) return node;
  return genome.inputs() + 1 + position_[genome.node_place(node)];
}

void GenomeCompiler::append(std::uint32_t place, std::uint32_t source, float weight) {
  const std::uint32_t k = end_[place]++;
  source_[k] = source;
  weight_[k] = weight;
}

// Links from inputs, whose numbers stay: run by run of enabled ones.
void GenomeCompiler::copy_enabled(const Genome& genome, const StartStructure::Segment& s, std::uint32_t& to) {
  const auto flags = genome.flags();
  for (std::uint32_t i = s.first; i < s.first + s.count;) {
    const std::uint32_t left = s.first + s.count - i, in_word = 64 - i % 64;
    const std::uint64_t bits = flags[i / 64] >> (i % 64);
    const std::uint32_t run = std::min({static_cast<std::uint32_t>(std::countr_one(bits)), in_word, left});
    std::copy_n(genome.start().source.begin() + i, run, source_.begin() + to);
    std::copy_n(genome.weights().begin() + i, run, weight_.begin() + to);
    to += run;
    i += run < in_word ? run + 1 : run;  // over the disabled link
  }
}

void GenomeCompiler::fill_links(const Genome& genome) {
  const StartStructure& start = genome.start();
  for (const StartStructure::Segment& s : start.segment) {
    const std::uint32_t place = genome.node_place(s.target);
    if (live_[place] == 0) continue;
    if (has_inner_source(start, s)) {
      for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
        if (genome.enabled(i)) append(place, value_of(genome, start.source[i]), genome.weight(i));
    } else {
      copy_enabled(genome, s, end_[place]);
      sorted_[place] = end_[place];
    }
  }
  const auto ends = genome.late_ends();
  for (std::uint32_t k = 0; k < ends.size(); ++k) {
    const std::uint32_t i = start.links() + k;
    if (!genome.enabled(i)) continue;
    const std::uint32_t place = genome.node_place(ends[k].target());
    if (live_[place] != 0) append(place, value_of(genome, ends[k].source()), genome.weight(i));
  }
}

// The start's links from inputs ascend already. The few behind them are inserted one by one, many are sorted.
void GenomeCompiler::sort_sources() {
  constexpr std::uint32_t kFew = 16;
  for (const std::uint32_t place : order_) {
    const std::uint32_t begin = first_link_[position_[place]], end = end_[place];
    if (end - sorted_[place] > kFew) {
      sort_many(begin, sorted_[place], end);
      continue;
    }
    for (std::uint32_t k = std::max(sorted_[place], begin + 1); k < end; ++k) {
      const std::uint32_t source = source_[k];
      if (source_[k - 1] < source) continue;
      const float weight = weight_[k];
      const auto to =
          std::lower_bound(source_.begin() + begin, source_.begin() + k, source) - source_.begin();
      std::copy_backward(source_.begin() + to, source_.begin() + k, source_.begin() + k + 1);
      std::copy_backward(weight_.begin() + to, weight_.begin() + k, weight_.begin() + k + 1);
      source_[static_cast<std::size_t>(to)] = source;
      weight_[static_cast<std::size_t>(to)] = weight;
    }
  }
}

void GenomeCompiler::sort_many(std::uint32_t begin, std::uint32_t sorted, std::uint32_t end) {
  sorting_.clear();
  for (std::uint32_t k = begin; k < end; ++k) sorting_.emplace_back(source_[k], weight_[k]);
  const auto by_source = [](const auto& a, const auto& b) { return a.first < b.first; };  // sources differ
  const auto middle = sorting_.begin() + (sorted - begin);
  std::sort(middle, sorting_.end(), by_source);
  std::inplace_merge(sorting_.begin(), middle, sorting_.end(), by_source);
  for (std::uint32_t k = begin; k < end; ++k) std::tie(source_[k], weight_[k]) = sorting_[k - begin];
}

NetworkColumns GenomeCompiler::columns(const Genome& genome, int only) {
  count_links(genome);
  gather_edges(genome);
  order_nodes(genome, only);
  position_.assign(genome.computed_nodes(), 0);
  end_.assign(genome.computed_nodes(), 0);
  sorted_.assign(genome.computed_nodes(), 0);
  activation_.clear();
  bias_.clear();
  first_link_.assign(1, 0);
  for (std::uint32_t n = 0; n < order_.size(); ++n) {
    const std::uint32_t place = order_[n];
    position_[place] = n;
    end_[place] = sorted_[place] = first_link_.back();
    first_link_.push_back(first_link_.back() + count_[place]);
    activation_.push_back(static_cast<std::uint8_t>(genome.activation(place)));
    bias_.push_back(genome.bias(place));
  }
  source_.resize(first_link_.back());
  weight_.resize(first_link_.back());
  fill_links(genome);
  sort_sources();
  output_node_.clear();
  for (std::uint32_t o = 0; o < genome.outputs(); ++o)
    if (only < 0 || only == static_cast<int>(o)) output_node_.push_back(genome.inputs() + 1 + position_[o]);
  return {.inputs = genome.inputs(),
          .recurrent = recurrent_,
          .activation = activation_,
          .bias = bias_,
          .first_link = first_link_,
          .source = source_,
          .weight = weight_,
          .output_node = output_node_};
}

}  // namespace evograsp::neat
