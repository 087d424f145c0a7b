#include "neat/express.h"

namespace evograsp::neat {

void Expressor::express(const Genome& genome, proto::Network& out) {
  if (substrate_) {
    out = substrate_->express(genome, compiler_).to_proto();
    return;
  }
  const NetworkColumns columns = compiler_.columns(genome);
  out.Clear();
  out.set_version(1);
  out.set_inputs(columns.inputs);
  out.set_outputs(static_cast<std::uint32_t>(columns.output_node.size()));
  out.mutable_activation()->Add(columns.activation.begin(), columns.activation.end());
  for (const float bias : columns.bias) out.add_bias(bias + 0.0f);  // never -0
  out.mutable_first_link()->Add(columns.first_link.begin(), columns.first_link.end());
  out.mutable_source()->Add(columns.source.begin(), columns.source.end());
  out.mutable_weight()->Add(columns.weight.begin(), columns.weight.end());
  out.mutable_output_node()->Add(columns.output_node.begin(), columns.output_node.end());
  out.set_recurrent(columns.recurrent);
}

}  // namespace evograsp::neat
