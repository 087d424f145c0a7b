#include "neat/mutation.h"

#include <algorithm>
#include <bit>

#include "neat/topology.h"

namespace evograsp::neat {
namespace {

// What mutate_weights() does to each weight, in single precision.
struct WeightStep {
  std::uint64_t perturb_below;  // of 2^32
  float perturb, replace, limit;

  explicit WeightStep(const proto::NeatConfig& config)
      : perturb_below(static_cast<std::uint64_t>(config.perturb_weight() * 0x1p32)),
        perturb(static_cast<float>(config.perturb_power())),
        replace(static_cast<float>(config.initial_weight())),
        limit(static_cast<float>(config.max_weight())) {}

  // High half of the draw: perturb or replace; low half: by how much, in [-1, 1) with 24 bits.
  float operator()(float weight, std::uint64_t draw, float scale) const {
    const float unit = static_cast<float>(static_cast<std::int32_t>(draw) >> 8) * 0x1p-23f;
    const bool keep = (draw >> 32) < perturb_below;
    const float moved = (keep ? weight : 0.0f) + unit * (keep ? perturb : replace) * scale;
    return std::min(std::max(moved, -limit), limit);
  }
};

// Place of the n-th enabled link, counted from 0.
std::uint32_t nth_enabled(const Genome& genome, std::uint32_t n) {
  const auto flags = genome.flags();
  std::size_t word = 0;
  for (;; ++word) {
    const auto ones = static_cast<std::uint32_t>(std::popcount(flags[word]));
    if (n < ones) break;
    n -= ones;
  }
  std::uint64_t bits = flags[word];
  for (; n > 0; --n) bits &= bits - 1;
  return static_cast<std::uint32_t>(word * 64) + static_cast<std::uint32_t>(std::countr_zero(bits));
}

std::uint32_t enabled_links(const Genome& genome) {
  std::uint32_t count = 0;
  for (const std::uint64_t word : genome.flags()) count += static_cast<std::uint32_t>(std::popcount(word));
  return count;
}

}  // namespace

void mutate_weights(Genome& genome, const proto::NeatConfig& config, Random& random) {
  const WeightStep step(config);
  const StartStructure& start = genome.start();
  const std::span<float> weight = genome.weights();
  const std::size_t early = start.links();
  if (start.scale.empty()) {
    for (std::size_t i = 0; i < early; ++i) weight[i] = step(weight[i], random.next(), 1.0f);
  } else {
    for (std::size_t i = 0; i < early; ++i) weight[i] = step(weight[i], random.next(), start.scale[i]);
  }
  const auto source = genome.late_source();
  for (std::size_t i = early; i < weight.size(); ++i)
    weight[i] = step(weight[i], random.next(), start.scale_of(source[i - early]));
}

Activation draw_activation(const proto::NeatConfig& config, Random& random) {
  if (config.hidden_choice_size() == 0) return static_cast<Activation>(config.hidden_activation());
  const auto pick = random.below(static_cast<std::uint32_t>(config.hidden_choice_size()));
  return static_cast<Activation>(config.hidden_choice(static_cast<int>(pick)));
}

bool add_node(Genome& genome, const proto::NeatConfig& config, Innovations& innovations, Random& random) {
  const std::uint32_t candidates = enabled_links(genome);
  if (candidates == 0) return false;
  constexpr int kTries = 8;  // only bias links make a draw fail
  for (int t = 0; t < kTries; ++t) {
    const std::uint32_t i = nth_enabled(genome, random.below(candidates));
    const Link old = genome.link(i);
    if (old.source == genome.bias_node()) continue;
    const Innovations::Split split = innovations.split(old.innovation);
    genome.set_enabled(i, false);
    genome.insert_hidden(split.node, draw_activation(config, random), 0.0f);
    genome.insert({split.link_in, old.source, split.node, 1.0f, true});
    genome.insert({split.link_out, split.node, old.target, old.weight, true});
    return true;
  }
  return false;
}

bool add_connection(Genome& genome, const proto::NeatConfig& config, Innovations& innovations,
                    Random& random) {
  const std::uint32_t inputs = genome.inputs() + 1;  // the bias is one
  const std::uint32_t sources =
      inputs + (config.recurrent() ? genome.computed_nodes() : genome.hidden_nodes());
  const std::uint32_t hidden_from = config.recurrent() ? 0 : genome.outputs();
  constexpr int kTries = 32;
  for (int t = 0; t < kTries; ++t) {
    const std::uint32_t from = random.below(sources);
    const std::uint32_t to = random.below(genome.computed_nodes());
    const std::uint32_t source = from < inputs ? from : genome.node_id(from - inputs + hidden_from);
    const std::uint32_t target = genome.node_id(to);
    if (genome.has_link(source, target)) continue;
    if (!config.recurrent() && closes_cycle(genome, source, target)) continue;
    const double reach = config.initial_weight() * static_cast<double>(genome.start().scale_of(source));
    const auto weight = static_cast<float>(random.uniform(-reach, reach));
    genome.insert({innovations.link(source, target), source, target, weight, true});
    return true;
  }
  return false;
}

void toggle_enabled(Genome& genome, Random& random) {
  if (genome.links() == 0) return;
  const std::uint32_t i = random.below(genome.links());
  genome.set_enabled(i, !genome.enabled(i));
}

void reenable(Genome& genome) {
  for (std::uint32_t i = 0; i < genome.links(); ++i) {
    if (genome.enabled(i)) continue;
    genome.set_enabled(i, true);
    return;
  }
}

void mutate_biases(Genome& genome, const proto::NeatConfig& config, Random& random) {
  const WeightStep step(config);
  for (std::uint32_t k = 0; k < genome.computed_nodes(); ++k)
    genome.set_bias(k, step(genome.bias(k), random.next(), 1.0f));
}

void mutate_activation(Genome& genome, const proto::NeatConfig& config, Random& random) {
  if (genome.hidden_nodes() == 0) return;
  const std::uint32_t place = genome.outputs() + random.below(genome.hidden_nodes());
  genome.set_activation(place, draw_activation(config, random));
}

void mutate(Genome& genome, const proto::NeatConfig& config, Innovations& innovations, Random& random) {
  if (random.chance(config.add_node())) add_node(genome, config, innovations, random);
  if (random.chance(config.add_connection())) add_connection(genome, config, innovations, random);
  if (random.chance(config.mutate_weights())) mutate_weights(genome, config, random);
  if (random.chance(config.mutate_bias())) mutate_biases(genome, config, random);
  if (random.chance(config.mutate_activation())) mutate_activation(genome, config, random);
  if (random.chance(config.toggle_enabled())) toggle_enabled(genome, random);
  if (random.chance(config.reenable())) reenable(genome);
}

}  // namespace evograsp::neat
