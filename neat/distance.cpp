#include "neat/distance.h"

#include <algorithm>
#include <cmath>

#include "neat/weight_kernels.h"

namespace evograsp::neat {

double distance(const Genome& a, const Genome& b, const DistanceWeights& c) {
  const std::uint32_t start = a.start_links();
  const auto ours = a.late_innovation(), theirs = b.late_innovation();
  double difference =
      static_cast<double>(weight_kernels().difference(a.weights().data(), b.weights().data(), start));
  std::uint32_t matching = start, disjoint = 0;
  std::size_t i = 0, j = 0;
  while (i < ours.size() && j < theirs.size()) {
    if (ours[i] == theirs[j]) {
      difference += std::fabs(static_cast<double>(a.weights()[start + i]) -
                              static_cast<double>(b.weights()[start + j]));
      ++matching, ++i, ++j;
    } else {
      ++disjoint;
      ++(ours[i] < theirs[j] ? i : j);
    }
  }
  const std::size_t excess = (ours.size() - i) + (theirs.size() - j);
  constexpr std::uint32_t kSmall = 20;
  const std::uint32_t larger = std::max(a.links(), b.links());
  const double n = c.by_genes && larger >= kSmall ? larger : 1;
  const double mean = matching > 0 ? difference / matching : 0.0;
  return c.excess * static_cast<double>(excess) / n + c.disjoint * disjoint / n + c.weight * mean;
}

}  // namespace evograsp::neat
