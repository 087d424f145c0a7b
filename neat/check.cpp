#include <cmath>
#include <string>
#include <unordered_set>

#include "common/network.h"
#include "neat/genome.h"
#include "neat/topology.h"

namespace evograsp::neat {
namespace {

tl::unexpected<Error> bad(const Genome& genome, const std::string& what) {
  return fail(ErrorCode::kInvalid, "genome " + std::to_string(genome.id()) + ": " + what);
}

// What a network may hold; false for NaN.
bool within(float value) {
  return std::fabs(value) <= Network::kMaxWeight;
}

Status check_nodes(const Genome& genome) {
  std::uint32_t last = 0;
  for (std::uint32_t j = 0; j < genome.hidden_nodes(); ++j) {
    const std::uint32_t node = genome.hidden_id(j);
    if (node < genome.start().first_hidden())
      return bad(genome, "a hidden node has the number of another kind");
    if (j < genome.start().hidden && node != genome.start().first_hidden() + j)
      return bad(genome, "a hidden node of the start is missing");
    if (j > 0 && node <= last) return bad(genome, "hidden nodes must ascend");
    last = node;
  }
  for (std::uint32_t k = 0; k < genome.computed_nodes(); ++k) {
    if (static_cast<int>(genome.activation(k)) >= kActivations) return bad(genome, "unknown activation");
    if (!within(genome.bias(k))) return bad(genome, "a bias is not within +-1048576");
  }
  return {};
}

Status check_links(const Genome& genome) {
  std::unordered_set<std::uint64_t> pairs;  // lookup only
  for (std::uint32_t i = 0; i < genome.links(); ++i) {
    const Link link = genome.link(i);
    const std::string name = "link " + std::to_string(link.innovation) + ": ";
    if (i > 0 && link.innovation <= genome.innovation(i - 1))
      return bad(genome, name + "innovations must ascend");
    if (!within(link.weight)) return bad(genome, name + "weight is not within +-1048576");
    if (genome.node_place(link.target) >= genome.computed_nodes())
      return bad(genome, name + "no such target");
    if (link.source > genome.bias_node() && genome.node_place(link.source) >= genome.computed_nodes())
      return bad(genome, name + "no such source");
    if (!pairs.insert(std::uint64_t{link.source} << 32 | link.target).second)
      return bad(genome, name + "is double");
  }
  return {};
}

}  // namespace

Status check(const Genome& genome, bool recurrent) {
  if (Status status = check_nodes(genome); !status) return status;
  if (Status status = check_links(genome); !status) return status;
  if (!recurrent && !is_acyclic(genome)) return bad(genome, "its links hold a cycle");
  return {};
}

}  // namespace evograsp::neat
