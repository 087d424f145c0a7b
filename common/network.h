// The phenotype: a network as a slot or a robot runs it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/network_kernels.h"
#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp {

// Synchronous updates that a recurrent network gets for one decision, wherever it runs: enough for an input
// to pass three hidden nodes in a row.
inline constexpr int kRecurrentSteps = 4;

// The columns of a network, wherever they are stored: see proto::Network for their meaning.
struct NetworkColumns {
  std::uint32_t inputs = 0;
  bool recurrent = false;
  std::span<const std::uint8_t> activation;   // of each computed node, numbered as proto::Activation
  std::span<const float> bias;                // of each computed node
  std::span<const std::uint32_t> first_link;  // computed nodes + 1
  std::span<const std::uint32_t> source;      // of each link: strictly ascending within a node
  std::span<const float> weight;
  std::span<const std::uint32_t> output_node;
};

// A compiled network. Immutable after construction and safe to share between threads; each thread brings its
// own Scratch. Activation allocates nothing once a Scratch has been sized by the first call.
//
// Nodes: inputs, bias (always 1), then the computed nodes in evaluation order. A computed node's value is
// f(sum of weight x source value + bias); the order of summation is in network_kernels.h, f in activation.h.
//
// Bits: activate(), activate_batch() and activate_columns() give the same bits for the same input, on every
// x86-64 machine and with either compiler (fixed summation order, own activation functions, no fused
// multiply-add). If an input is NaN or infinite, every output is NaN; otherwise every output is finite.
class Network {
 public:
  static constexpr std::uint32_t kMaxNodes = 1u << 20;
  static constexpr std::uint32_t kMaxLinks = 1u << 22;
  static constexpr float kMaxWeight = 0x1p20f;  // of links and biases
  static constexpr int kMaxSteps = 1000;        // of a recurrent network; more are not made
  static constexpr int kColumns = kernels::kColumns;

  struct Scratch {
    std::vector<float> values;
  };
  // What step() remembers; belongs to one network.
  struct State {
    std::vector<float> values;
    bool second = false;  // which half holds the last update
  };

  // Check everything (counts, ranges, ascending sources, sources before their targets unless recurrent): what
  // they get may come from a stranger.
  static Result<Network> from_proto(const proto::Network& proto);
  static Result<Network> from_columns(const NetworkColumns& columns);
  // The same without the checks, for columns that somebody has just made right (neat's compilers).
  static Network from_sound_columns(const NetworkColumns& columns);
  proto::Network to_proto() const;

  int inputs() const { return inputs_; }
  int outputs() const { return static_cast<int>(output_node_.size()); }
  int links() const { return static_cast<int>(source_.size()); }
  int computed_nodes() const { return static_cast<int>(node_.size()); }
  bool recurrent() const { return recurrent_; }

  // One evaluation. in: inputs() values; out: outputs() values. A recurrent network starts from zero state
  // and makes `steps` synchronous updates: every node reads what the nodes before it held one update ago
  // (ignored when feed-forward).
  void activate(std::span<const float> in, std::span<float> out, Scratch& scratch, int steps = 1) const;
  // One synchronous update of a recurrent network that keeps its state from call to call, as a controller in
  // a loop does; a fresh State is zero. A feed-forward network has no state: the same as activate(). An input
  // that is not finite gives NaN and leaves the state alone.
  void step(std::span<const float> in, std::span<float> out, State& state) const;
  // `count` evaluations; in: count x inputs(), out: count x outputs(), row-major. Fastest in multiples of 16.
  void activate_batch(std::span<const float> in, std::span<float> out, int count, Scratch& scratch,
                      int steps = 1) const;
  // kColumns evaluations, a sample a column: input i of sample c is in[i x kColumns + c], output o is
  // out[o x kColumns + c]. Faster than activate_batch() for small networks that many points are put to
  // (CPPNs).
  void activate_columns(std::span<const float> in, std::span<float> out, Scratch& scratch,
                        int steps = 1) const;

 private:
  kernels::Program program() const;
  std::uint32_t first_value() const { return static_cast<std::uint32_t>(inputs_) + 1; }
  void compile(const NetworkColumns& columns);
  void fill_blocks(const kernels::Node& node);
  template <class Step>
  float* update(float* from, float* to, int steps, Step once) const;
  bool activate_sixteen(const float* in, float* out, Scratch& scratch, int steps) const;
  void spoil_columns(std::span<const float> in, std::span<float> out) const;

  int inputs_ = 0;
  bool recurrent_ = false;
  std::uint32_t stride_ = 0;  // values of one sample, padded to whole blocks
  std::vector<kernels::Node> node_;
  std::vector<std::uint32_t> source_;
  std::vector<float> weight_;
  std::vector<kernels::Block> block_;
  std::vector<std::uint32_t> block_source_;
  std::vector<std::uint32_t> output_node_;
};

}  // namespace evograsp
