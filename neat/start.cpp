#include "neat/start.h"

#include <algorithm>
#include <vector>

namespace evograsp::neat {
namespace {

constexpr double kFeatureShare = 0.2;  // of initial_weight, that links from features get

void connect(StartStructure& start, std::uint32_t first_source, std::uint32_t count, std::uint32_t target) {
  if (count == 0) return;
  start.segment.push_back({target, start.links(), count});
  for (std::uint32_t i = 0; i < count; ++i) {
    start.source.push_back(first_source + i);
    start.target.push_back(target);
  }
}

float draw_weight(double reach, Random& random) {
  return static_cast<float>(random.uniform(-reach, reach));
}

// `count` different numbers below n, ascending.
std::vector<std::uint32_t> draw_different(std::uint32_t count, std::uint32_t n, Random& random) {
  std::vector<std::uint32_t> all(n);
  for (std::uint32_t i = 0; i < n; ++i) all[i] = i;
  count = std::min(count, n);
  for (std::uint32_t i = 0; i < count; ++i) std::swap(all[i], all[i + random.below(n - i)]);
  all.resize(count);
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

std::shared_ptr<const StartStructure> make_start(const proto::NeatConfig& config, std::uint32_t inputs,
                                                 std::uint32_t outputs) {
  auto start = std::make_shared<StartStructure>();
  start->inputs = inputs;
  start->outputs = outputs;
  start->depth_scale = static_cast<float>(config.depth_weight_scale());
  const std::uint32_t others = config.other_inputs();
  start->depth_inputs = inputs > others ? inputs - others : 0;
  const bool features = config.topology() == proto::FEATURES;
  const bool layered = (features || config.topology() == proto::HIDDEN_LAYER) && config.hidden() > 0;
  const bool direct =
      config.topology() == proto::DIRECT || (config.topology() == proto::HIDDEN_LAYER && !layered);
  // What a first layer reads: all inputs; the features with the bias.
  const std::uint32_t first = features ? start->depth_inputs : 0;
  const std::uint32_t read = features ? inputs + 1 - first : inputs;
  if (layered) {
    start->hidden = config.hidden();
    for (std::uint32_t h = 0; h < start->hidden; ++h) connect(*start, first, read, start->first_hidden() + h);
  }
  const bool bias = config.connect_bias_to_outputs() && !features && (layered || direct);
  for (std::uint32_t o = 0; o < outputs; ++o) {
    const std::uint32_t target = start->first_output() + o;
    if (direct) connect(*start, 0, inputs + bias, target);
    if (features) connect(*start, first, read, target);
    if (layered && bias) connect(*start, inputs, 1, target);
    if (layered) connect(*start, start->first_hidden(), start->hidden, target);
  }
  if (start->depth_scale != 1.0f)
    for (const std::uint32_t source : start->source) start->scale.push_back(start->scale_of(source));
  return start;
}

std::uint32_t first_free_innovation(const proto::NeatConfig& config, const StartStructure& start) {
  return config.topology() == proto::SPARSE ? start.inputs * start.outputs + 1 : start.links() + 1;
}

Genome make_first(const proto::NeatConfig& config, const std::shared_ptr<const StartStructure>& start,
                  Random& random) {
  Genome genome(start, static_cast<Activation>(config.hidden_activation()),
                static_cast<Activation>(config.output_activation()));
  const double reach = config.initial_weight();
  // A start of FEATURES answers nearly the same pose to every view: poses first, how they depend on the view
  // later.
  const double view = config.topology() == proto::FEATURES ? kFeatureShare : 1.0;
  const auto scaled = [&](std::uint32_t source) {
    return reach * (source == start->inputs ? 1.0 : view) * static_cast<double>(start->scale_of(source));
  };
  for (std::uint32_t h = 0; h < start->hidden; ++h)
    genome.set_activation(start->outputs + h, static_cast<Activation>(config.hidden_activation()));
  for (std::uint32_t i = 0; i < start->links(); ++i)
    genome.set_weight(i, draw_weight(scaled(start->source[i]), random));
  if (config.topology() != proto::SPARSE) return genome;
  for (std::uint32_t o = 0; o < start->outputs; ++o)
    for (const std::uint32_t source : draw_different(config.sparse_links(), start->inputs, random)) {
      const float weight = draw_weight(scaled(source), random);
      genome.insert({o * start->inputs + source + 1, source, start->first_output() + o, weight, true});
    }
  return genome;
}

}  // namespace evograsp::neat
