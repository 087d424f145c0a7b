#include "neat/mutation.h"

#include <algorithm>
#include <bit>

#include "common/det_math.h"
#include "neat/topology.h"
#include "neat/weight_kernels.h"

namespace evograsp::neat {
namespace {

WeightStep weight_step(const proto::NeatConfig& config) {
  const double below = config.perturb_weight() * 0x1p32;
  return {.perturb_below = static_cast<std::uint32_t>(std::clamp(below, 0.0, 0x1p32 - 1)),
          .always_perturb = below >= 0x1p32,
          .perturb = static_cast<float>(config.perturb_power()),
          .replace = static_cast<float>(config.initial_weight()),
          .limit = static_cast<float>(config.max_weight())};
}

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

double perturb_power(const proto::NeatConfig& config, std::uint32_t generation) {
  if (config.perturb_halving() == 0) return config.perturb_power();
  constexpr double kLn2 = 0.693147180559945309417;
  return config.perturb_power() * det::exp(-kLn2 * generation / config.perturb_halving());
}

void mutate_weights(Genome& genome, const proto::NeatConfig& config, Random& random) {
  const WeightStep step = weight_step(config);
  const WeightKernels& kernel = weight_kernels();
  const StartStructure& start = genome.start();
  float* weight = genome.weights().data();
  if (start.scale.empty() && start.depth_scale == 1.0f)
    return kernel.mutate(weight, nullptr, genome.links(), random.take(genome.links()), step);
  kernel.mutate(weight, start.scale.data(), start.links(), random.take(start.links()), step);
  const auto ends = genome.late_ends();
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const float scale = start.scale_of(ends[k].source());
    kernel.mutate(weight + start.links() + k, &scale, 1, random.take(1), step);
  }
}

Activation draw_activation(const proto::NeatConfig& config, Random& random) {
  if (config.hidden_choice_size() == 0) return static_cast<Activation>(config.hidden_activation());
  const auto pick = random.below(static_cast<std::uint32_t>(config.hidden_choice_size()));
  return static_cast<Activation>(config.hidden_choice(static_cast<int>(pick)));
}

bool add_node(Genome& genome, const proto::NeatConfig& config, Innovations& innovations, Random& random) {
  const std::uint32_t candidates = enabled_links(genome);
  if (candidates == 0 || innovations.next_node() >= kMaxNodeNumbers) return false;
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
  const std::uint32_t nodes = genome.computed_nodes();
  weight_kernels().mutate(genome.biases().data(), nullptr, nodes, random.take(nodes), weight_step(config));
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
