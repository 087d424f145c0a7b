// The phenotype: a network as a slot or a robot runs it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp {

// A compiled network. Immutable after construction and safe to share between threads; each thread brings its
// own Scratch. Activation allocates nothing once a Scratch has been sized by the first call.
//
// Bits: activate() and activate_batch() give the same bits for the same input, on every x86-64 machine and
// with either compiler (fixed summation order, own activation functions, no fused multiply-add).
class Network {
 public:
  struct Scratch {
    std::vector<float> values;
  };

  // Checks everything (counts, ranges, topological order unless recurrent): proto may come from a stranger.
  static Result<Network> from_proto(const proto::Network& proto);
  proto::Network to_proto() const;

  int inputs() const { return inputs_; }
  int outputs() const { return outputs_; }
  int links() const { return static_cast<int>(source_.size()); }
  bool recurrent() const { return recurrent_; }

  // One evaluation. in: inputs() values; out: outputs() values. A recurrent network starts from zero state
  // and makes `steps` synchronous updates (ignored when feed-forward).
  void activate(std::span<const float> in, std::span<float> out, Scratch& scratch, int steps = 1) const;
  // `count` evaluations; in: count x inputs(), out: count x outputs(), row-major.
  void activate_batch(std::span<const float> in, std::span<float> out, int count, Scratch& scratch,
                      int steps = 1) const;

 private:
  int inputs_ = 0;
  int outputs_ = 0;
  bool recurrent_ = false;
  std::vector<std::uint8_t> activation_;
  std::vector<float> bias_;
  std::vector<std::uint32_t> first_link_;
  std::vector<std::uint32_t> source_;
  std::vector<float> weight_;
  std::vector<std::uint32_t> output_node_;
};

}  // namespace evograsp
