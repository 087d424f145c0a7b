// Genomes in files: proto/genome.proto. What is read may be damaged or strange: all is checked.
#include <string>

#include "neat/genome.h"

namespace evograsp::neat {
namespace {

constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kMostEnds = 1'000'000;  // inputs, or outputs

tl::unexpected<Error> bad(const proto::Genome& proto, const std::string& what) {
  return fail(ErrorCode::kInvalid, "genome " + std::to_string(proto.id()) + ": " + what);
}

// The columns have lengths that belong together, and numbers fit where they are kept.
Status check_shape(const proto::Genome& proto) {
  if (proto.inputs() < 1 || proto.outputs() < 1 || proto.inputs() > kMostEnds || proto.outputs() > kMostEnds)
    return bad(proto, "inputs and outputs must be 1 to 1000000");
  const int nodes = proto.node_id_size(), links = proto.innovation_size();
  if (proto.node_activation_size() != nodes || proto.node_bias_size() != nodes ||
      static_cast<std::uint32_t>(nodes) < proto.outputs())
    return bad(proto, "its node columns differ in length, or lack outputs");
  if (proto.source_size() != links || proto.target_size() != links || proto.weight_size() != links ||
      proto.enabled().size() != static_cast<std::size_t>(links + 7) / 8)
    return bad(proto, "its link columns differ in length");
  for (const std::uint32_t f : proto.node_activation())
    if (f >= static_cast<std::uint32_t>(kActivations)) return bad(proto, "unknown activation");
  for (const std::uint32_t node : proto.node_id())
    if (node >= kMaxNodeNumbers) return bad(proto, "a node's number is too large");
  for (int i = 0; i < links; ++i)
    if (proto.source(i) >= kMaxNodeNumbers || proto.target(i) >= kMaxNodeNumbers)
      return bad(proto, "link " + std::to_string(proto.innovation(i)) + ": no such node");
  return {};
}

Status add_nodes(const proto::Genome& proto, Genome& genome) {
  const std::uint32_t first_output = proto.inputs() + 1;
  std::uint32_t last = 0;
  for (int k = 0; k < proto.node_id_size(); ++k) {
    const auto place = static_cast<std::uint32_t>(k);
    const std::uint32_t node = proto.node_id(k);
    const auto f = static_cast<Activation>(proto.node_activation(k));
    if (place < proto.outputs()) {
      if (node != first_output + place) return bad(proto, "its outputs do not come first, in order");
      genome.set_activation(place, f);
      genome.set_bias(place, proto.node_bias(k));
    } else {
      if (node <= last) return bad(proto, "hidden nodes must ascend, behind the outputs");
      genome.insert_hidden(node, f, proto.node_bias(k));
    }
    last = node;
  }
  return {};
}

Status add_links(const proto::Genome& proto, Genome& genome) {
  std::uint32_t last = 0;
  for (int i = 0; i < proto.innovation_size(); ++i) {
    const std::uint32_t innovation = proto.innovation(i);
    if (innovation <= last)
      return bad(proto, "link " + std::to_string(innovation) + ": innovations must ascend from 1");
    last = innovation;
    const bool enabled = (proto.enabled()[static_cast<std::size_t>(i) / 8] >> (i % 8) & 1) != 0;
    genome.insert({innovation, proto.source(i), proto.target(i), proto.weight(i), enabled});
  }
  return {};
}

}  // namespace

proto::Genome to_proto(const Genome& genome) {
  proto::Genome proto;
  proto.set_version(kVersion);
  proto.set_id(genome.id());
  proto.set_inputs(genome.inputs());
  proto.set_outputs(genome.outputs());
  for (std::uint32_t k = 0; k < genome.computed_nodes(); ++k) {
    proto.add_node_id(genome.node_id(k));
    proto.add_node_activation(static_cast<std::uint32_t>(genome.activation(k)));
    proto.add_node_bias(genome.bias(k));
  }
  const std::uint32_t links = genome.links();
  std::string& enabled = *proto.mutable_enabled();
  enabled.assign((links + 7) / 8, '\0');
  for (std::uint32_t i = 0; i < links; ++i) {
    proto.add_innovation(genome.innovation(i));
    proto.add_source(genome.source(i));
    proto.add_target(genome.target(i));
    if (genome.enabled(i)) enabled[i / 8] = static_cast<char>(enabled[i / 8] | (1 << (i % 8)));
  }
  proto.mutable_weight()->Add(genome.weights().begin(), genome.weights().end());
  return proto;
}

Result<Genome> from_proto(const proto::Genome& proto, bool recurrent) {
  if (proto.version() != kVersion)
    return fail(ErrorCode::kUnsupported, "genome " + std::to_string(proto.id()) + ": version " +
                                             std::to_string(proto.version()) + " is not known; " +
                                             std::to_string(kVersion) + " is");
  if (Status s = check_shape(proto); !s) return tl::unexpected(s.error());
  auto start = std::make_shared<StartStructure>();
  start->inputs = proto.inputs();
  start->outputs = proto.outputs();
  Genome genome(std::move(start), Activation::kTanh, Activation::kTanh);
  genome.set_id(proto.id());
  if (Status s = add_nodes(proto, genome); !s) return tl::unexpected(s.error());
  if (Status s = add_links(proto, genome); !s) return tl::unexpected(s.error());
  if (Status s = check(genome, recurrent); !s) return tl::unexpected(s.error());
  return genome;
}

}  // namespace evograsp::neat
