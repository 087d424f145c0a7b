#include "neat/crossover.h"

#include <algorithm>

#include "neat/weight_kernels.h"

namespace evograsp::neat {
namespace {

// One chance a call, one bit a gene.
class Coins {
 public:
  explicit Coins(Random& random) : random_(random) {}
  bool flip() {
    if (left_ == 0) {
      bits_ = random_.next();
      left_ = 64;
    }
    --left_;
    const bool heads = (bits_ & 1) != 0;
    bits_ >>= 1;
    return heads;
  }

 private:
  Random& random_;
  std::uint64_t bits_ = 0;
  int left_ = 0;
};

// The start's links, which both parents have. The child holds the fitter parent's values.
void cross_start(const Genome& other, const proto::NeatConfig& config, bool average, Random& random,
                 Genome& child) {
  const WeightKernels& kernel = weight_kernels();
  const std::uint32_t links = child.start_links();
  float* weight = child.weights().data();
  const float* theirs = other.weights().data();
  for (std::uint32_t begin = 0; begin < links; begin += 64) {
    const std::uint32_t count = std::min(links - begin, 64u);
    if (average) {
      for (std::uint32_t i = begin; i < begin + count; ++i) weight[i] = 0.5f * (weight[i] + theirs[i]);
    } else {
      const std::uint64_t bits = random.next();
      kernel.choose(weight + begin, theirs + begin, count, &bits);
    }
    const std::uint64_t mask = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
    std::uint64_t& flags = child.flags()[begin / 64];
    std::uint64_t off = ~(flags & other.flags()[begin / 64]) & mask;
    flags |= mask;
    for (; off != 0; off &= off - 1)
      if (random.chance(config.disabled_in_either())) flags &= ~(off & -off);
  }
}

void cross_late(const Genome& other, const proto::NeatConfig& config, bool average, Random& random,
                Genome& child) {
  const auto mine = child.late_innovation(), theirs = other.late_innovation();
  const std::uint32_t start = child.start_links();
  Coins coins(random);
  for (std::uint32_t i = 0, j = 0; i < mine.size() && j < theirs.size();) {
    if (mine[i] != theirs[j]) {
      ++(mine[i] < theirs[j] ? i : j);
      continue;
    }
    const float a = child.weight(start + i), b = other.weight(start + j);
    const bool both = child.enabled(start + i) && other.enabled(start + j);
    const bool take_theirs = coins.flip();
    child.set_weight(start + i, average ? 0.5f * (a + b) : take_theirs ? b : a);
    child.set_enabled(start + i, both || !random.chance(config.disabled_in_either()));
    ++i, ++j;
  }
}

void cross_nodes(const Genome& other, Random& random, Genome& child) {
  Coins coins(random);
  for (std::uint32_t k = 0; k < child.computed_nodes(); ++k) {
    const std::uint32_t place = other.node_place(child.node_id(k));
    if (place == other.computed_nodes() || !coins.flip()) continue;
    child.set_bias(k, other.bias(place));
    child.set_activation(k, other.activation(place));
  }
}

}  // namespace

void crossover(const Genome& fitter, const Genome& other, const proto::NeatConfig& config, Random& random,
               Genome& child) {
  child = fitter;
  const bool average = random.chance(config.mate_average());
  cross_start(other, config, average, random, child);
  cross_late(other, config, average, random, child);
  cross_nodes(other, random, child);
}

}  // namespace evograsp::neat
