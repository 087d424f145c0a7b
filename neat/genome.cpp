#include "neat/genome.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace evograsp::neat {

bool StartStructure::contains(std::uint32_t source_node, std::uint32_t target_node) const {
  for (const Segment& s : segment) {
    if (s.target != target_node) continue;
    const auto begin = source.begin() + s.first;
    if (std::binary_search(begin, begin + s.count, source_node)) return true;
  }
  return false;
}

Genome::Genome(std::shared_ptr<const StartStructure> start, Activation hidden, Activation output)
    : start_(std::move(start)) {
  const std::uint32_t nodes = start_->outputs + start_->hidden;
  activation_.assign(nodes, static_cast<std::uint8_t>(hidden));
  std::fill_n(activation_.begin(), start_->outputs, static_cast<std::uint8_t>(output));
  bias_.assign(nodes, 0.0f);
  for (std::uint32_t h = 0; h < start_->hidden; ++h) hidden_.push_back(start_->first_hidden() + h);
  const std::uint32_t links = start_->links();
  weight_.assign(links, 0.0f);
  enabled_.assign((links + 63) / 64, ~std::uint64_t{0});
  if (links % 64 != 0) enabled_.back() = (std::uint64_t{1} << (links % 64)) - 1;
}

bool Genome::has_link(std::uint32_t source_node, std::uint32_t target_node) const {
  bool found = false;
  for (std::size_t k = 0; k < late_source_.size(); ++k)
    found |= late_source_[k] == source_node && late_target_[k] == target_node;
  return found || start_->contains(source_node, target_node);
}

void Genome::set_enabled(std::uint32_t i, bool on) {
  const std::uint64_t bit = std::uint64_t{1} << (i % 64);
  enabled_[i / 64] = on ? enabled_[i / 64] | bit : enabled_[i / 64] & ~bit;
}

void Genome::insert(const Link& link) {
  const auto place = std::upper_bound(late_innovation_.begin(), late_innovation_.end(), link.innovation);
  const auto k = place - late_innovation_.begin();
  const std::uint32_t i = start_links() + static_cast<std::uint32_t>(k);
  late_innovation_.insert(place, link.innovation);
  late_source_.insert(late_source_.begin() + k, link.source);
  late_target_.insert(late_target_.begin() + k, link.target);
  weight_.insert(weight_.begin() + i, link.weight);
  const std::uint32_t count = links();
  if (count > enabled_.size() * 64) enabled_.push_back(0);
  for (std::uint32_t j = count - 1; j > i; --j) set_enabled(j, enabled(j - 1));
  set_enabled(i, link.enabled);
}

std::uint32_t Genome::node_place(std::uint32_t node) const {
  if (node >= start_->first_output() && node < start_->first_hidden()) return node - start_->first_output();
  // Hidden nodes of the start come first and without gaps.
  const std::uint32_t from_start = node - start_->first_hidden();
  if (node >= start_->first_hidden() && from_start < start_->hidden) return outputs() + from_start;
  const auto place = std::lower_bound(hidden_.begin(), hidden_.end(), node);
  if (place == hidden_.end() || *place != node) return computed_nodes();
  return outputs() + static_cast<std::uint32_t>(place - hidden_.begin());
}

void Genome::insert_hidden(std::uint32_t node, Activation f, float bias) {
  const auto place = std::lower_bound(hidden_.begin(), hidden_.end(), node);
  const auto k = static_cast<std::ptrdiff_t>(outputs()) + (place - hidden_.begin());
  hidden_.insert(place, node);
  activation_.insert(activation_.begin() + k, static_cast<std::uint8_t>(f));
  bias_.insert(bias_.begin() + k, bias);
}

std::size_t Genome::bytes() const {
  return hidden_.size() * 4 + activation_.size() + bias_.size() * 4 + late_innovation_.size() * 12 +
         weight_.size() * 4 + enabled_.size() * 8;
}

bool Genome::operator==(const Genome& other) const {
  return *start_ == *other.start_ && hidden_ == other.hidden_ && activation_ == other.activation_ &&
         bias_ == other.bias_ && late_innovation_ == other.late_innovation_ &&
         late_source_ == other.late_source_ && late_target_ == other.late_target_ &&
         weight_ == other.weight_ && enabled_ == other.enabled_;
}

proto::Genome to_proto(const Genome& genome) {
  proto::Genome proto;
  proto.set_version(1);
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

}  // namespace evograsp::neat
