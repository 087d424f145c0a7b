#include "common/network.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "common/activation.h"

namespace evograsp {
namespace {

using kernels::kLanes;

static_assert(static_cast<int>(Activation::kSteepSigmoid) == proto::STEEP_SIGMOID);
static_assert(static_cast<int>(Activation::kTanh) == proto::TANH);
static_assert(static_cast<int>(Activation::kRelu) == proto::RELU);
static_assert(static_cast<int>(Activation::kLinear) == proto::LINEAR);
static_assert(static_cast<int>(Activation::kSine) == proto::SINE);
static_assert(static_cast<int>(Activation::kGaussian) == proto::GAUSSIAN);
static_assert(static_cast<int>(Activation::kAbs) == proto::ABS);
static_assert(static_cast<int>(Activation::kStep) == proto::STEP);
static_assert(kActivations == proto::Activation_ARRAYSIZE);

tl::unexpected<Error> bad(const std::string& what) {
  return fail(ErrorCode::kInvalid, "network: " + what);
}

bool within(float value, float limit) {
  return std::fabs(value) <= limit;
}  // false for NaN

Status check_counts(const NetworkColumns& c) {
  if (c.inputs < 1 || c.inputs > Network::kMaxNodes) return bad("inputs must be 1 to 1048576");
  if (c.activation.size() > Network::kMaxNodes - 1 || c.inputs + 1 + c.activation.size() > Network::kMaxNodes)
    return bad("more than 1048576 nodes");
  if (c.bias.size() != c.activation.size()) return bad("one bias a computed node is needed");
  if (c.first_link.size() != c.activation.size() + 1)
    return bad("first_link needs one entry a computed node and one more");
  if (c.source.size() > Network::kMaxLinks) return bad("more than 4194304 links");
  if (c.weight.size() != c.source.size()) return bad("one weight a link is needed");
  if (c.first_link.front() != 0 || c.first_link.back() != c.source.size())
    return bad("first_link must run from 0 to the number of links");
  if (c.output_node.empty() || c.output_node.size() > Network::kMaxNodes)
    return bad("outputs must be 1 to 1048576");
  return {};
}

Status check_node(const NetworkColumns& c, std::uint32_t i) {
  const auto at = [i] { return "node " + std::to_string(i) + ": "; };
  if (c.activation[i] >= kActivations) return bad(at() + "unknown activation");
  if (!within(c.bias[i], Network::kMaxWeight)) return bad(at() + "bias is not within +-1048576");
  const std::uint32_t begin = c.first_link[i], end = c.first_link[i + 1];
  if (begin > end || end > c.source.size()) return bad(at() + "first_link must not fall");
  if (begin == end) return {};
  const std::uint32_t own = c.inputs + 1 + i;
  const auto limit = c.recurrent ? c.inputs + 1 + static_cast<std::uint32_t>(c.activation.size()) : own;
  bool good = true;
  for (std::uint32_t k = begin + 1; k < end; ++k) good &= c.source[k - 1] < c.source[k];
  if (!good) return bad(at() + "sources must ascend");
  if (c.source[end - 1] >= limit)
    return bad(at() + (c.recurrent ? "a source does not exist" : "a source stands after its target"));
  for (std::uint32_t k = begin; k < end; ++k) good &= within(c.weight[k], Network::kMaxWeight);
  if (!good) return bad(at() + "a weight is not within +-1048576");
  return {};
}

Status check(const NetworkColumns& c) {
  if (Status status = check_counts(c); !status) return status;
  const auto nodes = static_cast<std::uint32_t>(c.activation.size());
  for (std::uint32_t i = 0; i < nodes; ++i) {
    if (Status status = check_node(c, i); !status) return status;
  }
  for (const std::uint32_t node : c.output_node) {
    if (node >= c.inputs + 1 + nodes) return bad("an output names no node");
  }
  return {};
}

// True if the sources from `source` on fill one whole block; they ascend.
bool whole_block(const std::uint32_t* source) {
  return source[0] % kLanes == 0 && source[kLanes - 1] == source[0] + kLanes - 1;
}

// Blocks of 16 consecutive nodes that hold the sources, which ascend.
std::uint32_t blocks_of(std::span<const std::uint32_t> source) {
  std::uint32_t blocks = 0, last = ~0u;
  for (std::size_t k = 0; k < source.size();) {
    blocks += source[k] / kLanes != last;
    last = source[k] / kLanes;
    k += k + kLanes <= source.size() && whole_block(&source[k]) ? kLanes : 1;
  }
  return blocks;
}

void fill_nan(std::span<float> out) {
  std::fill(out.begin(), out.end(), std::numeric_limits<float>::quiet_NaN());
}

// Room for `count` floats on a cache line's boundary.
float* aligned(std::vector<float>& storage, std::size_t count) {
  if (storage.size() < count + kLanes) storage.resize(count + kLanes);
  void* p = storage.data();
  std::size_t space = storage.size() * sizeof(float);
  return static_cast<float*>(std::align(64, count * sizeof(float), p, space));
}

int bounded(int steps) {
  return std::clamp(steps, 1, Network::kMaxSteps);
}

}  // namespace

Result<Network> Network::from_columns(const NetworkColumns& columns) {
  if (Status status = check(columns); !status) return tl::unexpected(status.error());
  Network network;
  network.compile(columns);
  return network;
}

Network Network::from_sound_columns(const NetworkColumns& columns) {
  assert(check(columns));
  Network network;
  network.compile(columns);
  return network;
}

void Network::compile(const NetworkColumns& c) {
  inputs_ = static_cast<int>(c.inputs);
  recurrent_ = c.recurrent;
  source_.assign(c.source.begin(), c.source.end());
  weight_.assign(c.weight.begin(), c.weight.end());
  output_node_.assign(c.output_node.begin(), c.output_node.end());
  node_.resize(c.activation.size());
  const auto values = first_value() + static_cast<std::uint32_t>(node_.size());
  stride_ = (values + kLanes - 1) / kLanes * kLanes;
  std::uint32_t blocks = 0;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    kernels::Node& node = node_[i];
    node.activation = c.activation[i];
    node.bias = c.bias[i] + 0.0f;  // never -0
    node.first_link = c.first_link[i];
    node.links = c.first_link[i + 1] - node.first_link;
    const std::uint32_t needed = blocks_of({source_.data() + node.first_link, node.links});
    // A block costs about as much as a link by itself: single links stay single, and memory bounded by the
    // links'.
    if (node.links < 3 || 4 * node.links < 5 * needed) continue;
    node.first_block = blocks;
    node.blocks = needed;
    blocks += needed;
  }
  block_.resize(blocks);
  block_source_.resize(blocks);
  for (const kernels::Node& node : node_)
    if (node.blocks > 0) fill_blocks(node);
}

void Network::fill_blocks(const kernels::Node& node) {
  std::uint32_t b = node.first_block - 1, last = ~0u;
  for (std::uint32_t k = node.first_link, end = k + node.links; k < end;) {
    if (source_[k] / kLanes != last) {
      last = source_[k] / kLanes;
      block_source_[++b] = last * kLanes;
    }
    if (k + kLanes <= end && whole_block(&source_[k])) {
      std::copy_n(&weight_[k], kLanes, block_[b].weight);
      k += kLanes;
    } else {
      block_[b].weight[source_[k] % kLanes] = weight_[k];
      ++k;
    }
  }
}

kernels::Program Network::program() const {
  return {node_.data(),         static_cast<std::uint32_t>(node_.size()),
          first_value(),        block_.data(),
          block_source_.data(), source_.data(),
          weight_.data()};
}

Result<Network> Network::from_proto(const proto::Network& proto) {
  if (proto.version() != 1)
    return fail(ErrorCode::kUnsupported,
                "network: version " + std::to_string(proto.version()) + " is not known; 1 is");
  if (proto.activation_size() > static_cast<int>(kMaxNodes)) return bad("more than 1048576 nodes");
  std::vector<std::uint8_t> activation(static_cast<std::size_t>(proto.activation_size()));
  for (int i = 0; i < proto.activation_size(); ++i)
    activation[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::min(proto.activation(i), 255u));
  if (proto.outputs() != static_cast<std::uint32_t>(proto.output_node_size()))
    return bad("one output_node an output is needed");
  const auto span = [](const auto& field) {
    return std::span(field.data(), static_cast<std::size_t>(field.size()));
  };
  return from_columns({.inputs = proto.inputs(),
                       .recurrent = proto.recurrent(),
                       .activation = activation,
                       .bias = span(proto.bias()),
                       .first_link = span(proto.first_link()),
                       .source = span(proto.source()),
                       .weight = span(proto.weight()),
                       .output_node = span(proto.output_node())});
}

proto::Network Network::to_proto() const {
  proto::Network proto;
  proto.set_version(1);
  proto.set_inputs(static_cast<std::uint32_t>(inputs_));
  proto.set_outputs(static_cast<std::uint32_t>(output_node_.size()));
  for (const kernels::Node& node : node_) {
    proto.add_activation(node.activation);
    proto.add_bias(node.bias);
    proto.add_first_link(node.first_link);
  }
  proto.add_first_link(static_cast<std::uint32_t>(source_.size()));
  proto.mutable_source()->Add(source_.begin(), source_.end());
  proto.mutable_weight()->Add(weight_.begin(), weight_.end());
  proto.mutable_output_node()->Add(output_node_.begin(), output_node_.end());
  proto.set_recurrent(recurrent_);
  return proto;
}

// Runs the updates; returns where the last one wrote.
template <class Step>
float* Network::update(float* from, float* to, int steps, Step once) const {
  for (int s = recurrent_ ? bounded(steps) : 1; s > 0; --s) {
    once(program(), from, to);
    std::swap(from, to);
  }
  return from;
}

void Network::activate(std::span<const float> in, std::span<float> out, Scratch& scratch, int steps) const {
  assert(in.size() >= static_cast<std::size_t>(inputs_) && out.size() >= output_node_.size());
  const kernels::Kernels& kernel = kernels::active();
  const auto inputs = static_cast<std::uint32_t>(inputs_);
  float* from = aligned(scratch.values, std::size_t{stride_} * (recurrent_ ? 2 : 1));
  float* to = recurrent_ ? from + stride_ : from;
  if (!kernel.copy_finite(in.data(), inputs, from)) return fill_nan(out);
  from[inputs] = 1.0f;
  std::fill(from + inputs + 1, from + stride_, 0.0f);
  if (recurrent_) std::copy_n(from, stride_, to);
  const float* value = update(from, to, steps, kernel.one);
  for (std::size_t o = 0; o < output_node_.size(); ++o) out[o] = value[output_node_[o]];
}

void Network::step(std::span<const float> in, std::span<float> out, State& state) const {
  const kernels::Kernels& kernel = kernels::active();
  const auto inputs = static_cast<std::uint32_t>(inputs_);
  if (state.values.size() != 2 * std::size_t{stride_}) state.values.assign(2 * std::size_t{stride_}, 0.0f);
  float* from = state.values.data() + (state.second && recurrent_ ? stride_ : 0);
  float* to = recurrent_ ? state.values.data() + (state.second ? 0 : stride_) : from;
  if (!std::all_of(in.begin(), in.end(), [](float x) { return std::isfinite(x); })) return fill_nan(out);
  std::copy_n(in.data(), inputs, from);
  from[inputs] = 1.0f;
  if (recurrent_) std::copy_n(from, inputs + 1, to);
  kernel.one(program(), from, to);
  state.second = recurrent_ && !state.second;
  for (std::size_t o = 0; o < output_node_.size(); ++o) out[o] = to[output_node_[o]];
}

// 16 samples; false, with nothing done, if an input is not finite.
bool Network::activate_sixteen(const float* in, float* out, Scratch& scratch, int steps) const {
  const kernels::Kernels& kernel = kernels::active();
  const auto inputs = static_cast<std::uint32_t>(inputs_);
  const std::size_t size = std::size_t{stride_} * kLanes;
  float* from = aligned(scratch.values, size * (recurrent_ ? 2 : 1));
  float* to = recurrent_ ? from + size : from;
  // The last block of inputs also holds the bias and the first computed nodes.
  std::fill(from + kernels::batch_place(inputs / kLanes * kLanes, 0), from + size, 0.0f);
  if (!kernel.copy_finite_rows(in, inputs, from)) return false;
  for (std::uint64_t r = 0; r < kLanes; ++r) from[kernels::batch_place(inputs, r)] = 1.0f;
  if (recurrent_) std::copy_n(from, size, to);
  const float* value = update(from, to, steps, kernel.batch);
  for (std::uint64_t r = 0; r < kLanes; ++r)
    for (const std::uint32_t node : output_node_) *out++ = value[kernels::batch_place(node, r)];
  return true;
}

void Network::activate_batch(std::span<const float> in, std::span<float> out, int count, Scratch& scratch,
                             int steps) const {
  const auto inputs = static_cast<std::size_t>(inputs_), outputs = output_node_.size();
  const auto samples = static_cast<std::size_t>(std::max(count, 0));
  assert(in.size() >= samples * inputs && out.size() >= samples * outputs);
  const auto singles = [&](std::size_t first, std::size_t end) {
    for (std::size_t r = first; r < end; ++r)
      activate(in.subspan(r * inputs, inputs), out.subspan(r * outputs, outputs), scratch, steps);
  };
  std::size_t done = 0;
  for (; done + kLanes <= samples; done += kLanes)
    if (!activate_sixteen(in.data() + done * inputs, out.data() + done * outputs, scratch, steps))
      singles(done, done + kLanes);
  singles(done, samples);
}

void Network::activate_columns(std::span<const float> in, std::span<float> out, Scratch& scratch,
                               int steps) const {
  const kernels::Kernels& kernel = kernels::active();
  const auto inputs = static_cast<std::uint32_t>(inputs_);
  const std::size_t size = std::size_t{stride_} * kColumns;
  float* from = aligned(scratch.values, size * (recurrent_ ? 2 : 1));
  float* to = recurrent_ ? from + size : from;
  const bool finite = kernel.copy_finite(in.data(), inputs * std::uint32_t{kColumns}, from);
  std::fill_n(from + inputs * std::uint32_t{kColumns}, kColumns, 1.0f);
  if (recurrent_) {
    std::fill(from + (std::size_t{inputs} + 1) * kColumns, from + size, 0.0f);
    std::copy_n(from, size, to);
  }
  const float* value = update(from, to, steps, kernel.columns);
  for (std::size_t o = 0; o < output_node_.size(); ++o)
    std::copy_n(value + std::size_t{output_node_[o]} * kColumns, kColumns, out.data() + o * kColumns);
  if (!finite) spoil_columns(in, out);
}

// NaN into the outputs of columns that have an input that is not finite; columns do not touch each other.
void Network::spoil_columns(std::span<const float> in, std::span<float> out) const {
  for (std::size_t c = 0; c < kColumns; ++c) {
    bool finite = true;
    for (std::size_t i = 0; i < static_cast<std::size_t>(inputs_); ++i)
      finite &= std::isfinite(in[i * kColumns + c]);
    for (std::size_t o = 0; o < output_node_.size() && !finite; ++o)
      out[o * kColumns + c] = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace evograsp
