// The genotype (Stanley and Miikkulainen 2002, section 3.1): node genes and link genes with historical
// markings.
//
// Nodes are numbered 0 .. inputs-1 (inputs), inputs (bias), then outputs, then hidden nodes in order of
// birth. Links are sorted by innovation. The links every genome starts with (its StartStructure) are stored
// once for the whole population: of them a genome keeps its weights and flags alone, 4.1 bytes a gene; of the
// links that came later it keeps innovation, source and target as well, 14.1 bytes, and of a hidden node 9.
// Links are never deleted, so that the start structure stays a prefix of every genome.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/activation.h"
#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp::neat {

// One link gene, as a value.
struct Link {
  std::uint32_t innovation = 0, source = 0, target = 0;
  float weight = 0;
  bool enabled = true;
  bool operator==(const Link&) const = default;
};

// A run numbers fewer nodes than this.
inline constexpr std::uint32_t kMaxNodeNumbers = 1u << 24;

// Source and target of a link in six bytes.
class LinkEnds {
 public:
  LinkEnds(std::uint32_t source, std::uint32_t target)
      : low_{static_cast<std::uint16_t>(source), static_cast<std::uint16_t>(target)},
        high_{static_cast<std::uint8_t>(source >> 16), static_cast<std::uint8_t>(target >> 16)} {}
  std::uint32_t source() const { return low_[0] | static_cast<std::uint32_t>(high_[0]) << 16; }
  std::uint32_t target() const { return low_[1] | static_cast<std::uint32_t>(high_[1]) << 16; }
  bool operator==(const LinkEnds&) const = default;

 private:
  std::uint16_t low_[2];
  std::uint8_t high_[2];
};
static_assert(sizeof(LinkEnds) == 6);

// The links that all genomes of a population start with. Immutable and shared. Link i has innovation i + 1.
// Consecutive links with one target form a segment, in which sources ascend.
struct StartStructure {
  struct Segment {
    std::uint32_t target = 0, first = 0, count = 0;
  };
  std::uint32_t inputs = 0, outputs = 0, hidden = 0;
  std::vector<std::uint32_t> source, target;
  std::vector<float> scale;  // of weights and perturbations, by link; empty: 1
  std::vector<Segment> segment;
  float depth_scale = 1;  // of links from the first depth_inputs inputs
  std::uint32_t depth_inputs = 0;

  std::uint32_t links() const { return static_cast<std::uint32_t>(source.size()); }
  std::uint32_t first_output() const { return inputs + 1; }
  std::uint32_t first_hidden() const { return inputs + 1 + outputs; }
  float scale_of(std::uint32_t source_node) const { return source_node < depth_inputs ? depth_scale : 1.0f; }
  bool contains(std::uint32_t source_node, std::uint32_t target_node) const;
  bool operator==(const StartStructure& other) const {
    return source == other.source && target == other.target;
  }
};

class Genome {
 public:
  Genome() = default;
  // All links of the start structure, enabled, weights 0.
  Genome(std::shared_ptr<const StartStructure> start, Activation hidden, Activation output);

  std::uint64_t id() const { return id_; }  // unique in a run; a champion kept unchanged keeps its id
  void set_id(std::uint64_t id) { id_ = id; }
  std::uint32_t inputs() const { return start_->inputs; }
  std::uint32_t outputs() const { return start_->outputs; }
  std::uint32_t bias_node() const { return start_->inputs; }
  const StartStructure& start() const { return *start_; }
  const std::shared_ptr<const StartStructure>& shared_start() const { return start_; }

  // Links, sorted by innovation.
  std::uint32_t links() const { return static_cast<std::uint32_t>(weight_.size()); }
  std::uint32_t start_links() const { return start_->links(); }
  std::uint32_t innovation(std::uint32_t i) const {
    return i < start_links() ? i + 1 : late_innovation_[i - start_links()];
  }
  std::uint32_t source(std::uint32_t i) const {
    return i < start_links() ? start_->source[i] : late_ends_[i - start_links()].source();
  }
  std::uint32_t target(std::uint32_t i) const {
    return i < start_links() ? start_->target[i] : late_ends_[i - start_links()].target();
  }
  float weight(std::uint32_t i) const { return weight_[i]; }
  bool enabled(std::uint32_t i) const { return (enabled_[i / 64] >> (i % 64) & 1) != 0; }
  Link link(std::uint32_t i) const { return {innovation(i), source(i), target(i), weight(i), enabled(i)}; }
  bool has_link(std::uint32_t source_node, std::uint32_t target_node) const;

  void set_weight(std::uint32_t i, float weight) { weight_[i] = weight; }
  void set_enabled(std::uint32_t i, bool on);
  // Inserts at its place by innovation, which must be new to the genome and greater than the start's.
  void insert(const Link& link);

  // Nodes that compute: outputs first, then hidden nodes by ascending id.
  std::uint32_t computed_nodes() const { return outputs() + hidden_nodes(); }
  std::uint32_t hidden_nodes() const { return static_cast<std::uint32_t>(hidden_.size()); }
  std::uint32_t hidden_id(std::uint32_t j) const { return hidden_[j]; }
  std::uint32_t node_id(std::uint32_t k) const {
    return k < outputs() ? start_->first_output() + k : hidden_[k - outputs()];
  }
  // Place of a node among those that compute; computed_nodes() if the genome has no such node.
  std::uint32_t node_place(std::uint32_t node) const {
    // Outputs and the hidden nodes of the start come first and without gaps.
    const std::uint32_t from_outputs = node - start_->first_output();
    if (from_outputs < start_->outputs + start_->hidden) return from_outputs;
    return late_node_place(node);
  }
  Activation activation(std::uint32_t place) const { return static_cast<Activation>(activation_[place]); }
  float bias(std::uint32_t place) const { return bias_[place]; }
  void set_activation(std::uint32_t place, Activation f) {
    activation_[place] = static_cast<std::uint8_t>(f);
  }
  void set_bias(std::uint32_t place, float bias) { bias_[place] = bias; }
  std::span<float> biases() { return bias_; }
  void insert_hidden(std::uint32_t node, Activation f, float bias);

  // Columns, for inner loops. Weights of all links; flags, 64 a word, unused bits 0; links later than the
  // start.
  std::span<float> weights() { return weight_; }
  std::span<const float> weights() const { return weight_; }
  std::span<std::uint64_t> flags() { return enabled_; }
  std::span<const std::uint64_t> flags() const { return enabled_; }
  std::span<const std::uint32_t> late_innovation() const { return late_innovation_; }
  std::span<const LinkEnds> late_ends() const { return late_ends_; }

  std::size_t bytes() const;  // of memory, columns and what they keep in reserve; shared ones left out
  bool operator==(const Genome& other) const;

 private:
  std::uint32_t late_node_place(std::uint32_t node) const;

  std::uint64_t id_ = 0;
  std::shared_ptr<const StartStructure> start_;
  std::vector<std::uint32_t> hidden_;
  std::vector<std::uint8_t> activation_;
  std::vector<float> bias_;
  std::vector<std::uint32_t> late_innovation_;
  std::vector<LinkEnds> late_ends_;
  std::vector<float> weight_;
  std::vector<std::uint64_t> enabled_;
};

// Everything that must hold of a genome: sorted unique innovations, no dangling or doubled link, finite
// values, no cycle among its links (disabled ones included) unless recurrent, nothing computed into an input.
Status check(const Genome& genome, bool recurrent);

// The whole genome as columns, start structure included.
proto::Genome to_proto(const Genome& genome);
// The way back, of a message from anywhere: to_proto() of what comes out is the message again, and the
// network that it expresses the same. Such a genome stands alone: it shares no start structure, all its links
// count as later ones. kUnsupported for a version that is not known; kInvalid, with what is wrong, for
// columns that do not fit together, innovations or hidden nodes that do not ascend, and all that check()
// refuses.
Result<Genome> from_proto(const proto::Genome& proto, bool recurrent);

}  // namespace evograsp::neat
