#include "common/network.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
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

bool all_finite(std::span<const float> values) {
  // A sum of x * 0 is 0 only if every x is finite; eight partial sums keep the loop short.
  float sum[8] = {};
  std::size_t i = 0;
  for (; i + 8 <= values.size(); i += 8)
    for (std::size_t k = 0; k < 8; ++k) sum[k] += values[i + k] * 0.0f;
  for (; i < values.size(); ++i) sum[0] += values[i] * 0.0f;
  for (int k = 1; k < 8; ++k) sum[0] += sum[k];
  return sum[0] == 0.0f;
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

void Network::compile(const NetworkColumns& c) {
  inputs_ = static_cast<int>(c.inputs);
  recurrent_ = c.recurrent;
  source_.assign(c.source.begin(), c.source.end());
  weight_.assign(c.weight.begin(), c.weight.end());
  output_node_.assign(c.output_node.begin(), c.output_node.end());
  node_.resize(c.activation.size());
  const auto values = first_value() + static_cast<std::uint32_t>(node_.size());
  stride_ = (values + kLanes - 1) / kLanes * kLanes;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    kernels::Node& node = node_[i];
    node.activation = c.activation[i];
    node.bias = c.bias[i] + 0.0f;  // never -0
    node.first_link = c.first_link[i];
    node.links = c.first_link[i + 1] - node.first_link;
    const std::uint32_t* source = source_.data() + node.first_link;
    std::uint32_t blocks = 0;
    for (std::uint32_t k = 0, last = ~0u; k < node.links; ++k) {
      blocks += source[k] / kLanes != last;
      last = source[k] / kLanes;
    }
    // Denser than this a block is cheaper than its links one by one, and memory stays bounded by the links'.
    if (node.links < 3 || node.links < 2 * blocks) continue;
    node.first_block = static_cast<std::uint32_t>(block_.size());
    node.blocks = blocks;
    block_.resize(block_.size() + blocks);
    block_source_.resize(block_.size());
    kernels::Block* block = block_.data() + node.first_block - 1;
    std::uint32_t* block_source = block_source_.data() + node.first_block - 1;
    for (std::uint32_t k = 0, last = ~0u; k < node.links; ++k) {
      if (source[k] / kLanes != last) {
        last = source[k] / kLanes;
        ++block;
        *++block_source = last * kLanes;
      }
      block->weight[source[k] % kLanes] = weight_[node.first_link + k];
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

void Network::activate(std::span<const float> in, std::span<float> out, Scratch& scratch, int steps) const {
  if (!all_finite(in)) return fill_nan(out);
  const kernels::Kernels& kernel = kernels::active();
  const kernels::Program p = program();
  const auto inputs = static_cast<std::size_t>(inputs_);
  const int buffers = recurrent_ ? 2 : 1;
  float* from = aligned(scratch.values, stride_ * static_cast<std::size_t>(buffers));
  float* to = recurrent_ ? from + stride_ : from;
  for (float* row = from; row <= to; row += stride_) {
    std::memcpy(row, in.data(), inputs * sizeof(float));
    row[inputs] = 1.0f;
    std::fill(row + inputs + 1, row + stride_, 0.0f);
  }
  for (int s = recurrent_ ? bounded(steps) : 1; s > 0; --s) {
    kernel.one(p, from, to);
    std::swap(from, to);
  }
  for (std::size_t o = 0; o < output_node_.size(); ++o) out[o] = from[output_node_[o]];
}

void Network::activate_batch(std::span<const float> in, std::span<float> out, int count, Scratch& scratch,
                             int steps) const {
  const kernels::Kernels& kernel = kernels::active();
  const kernels::Program p = program();
  const auto inputs = static_cast<std::size_t>(inputs_), outputs = output_node_.size();
  int done = 0;
  for (; done + kLanes <= count; done += kLanes) {
    const std::span<const float> rows_in =
        in.subspan(static_cast<std::size_t>(done) * inputs, kLanes * inputs);
    const std::span<float> rows_out = out.subspan(static_cast<std::size_t>(done) * outputs, kLanes * outputs);
    if (!all_finite(rows_in)) {  // rare: each row for itself
      for (std::size_t r = 0; r < kLanes; ++r)
        activate(rows_in.subspan(r * inputs, inputs), rows_out.subspan(r * outputs, outputs), scratch, steps);
      continue;
    }
    float* from = aligned(scratch.values, std::size_t{stride_} * kLanes * (recurrent_ ? 2 : 1));
    float* to = recurrent_ ? from + std::size_t{stride_} * kLanes : from;
    for (float* buffer = from; buffer <= to; buffer += std::size_t{stride_} * kLanes) {
      for (std::size_t r = 0; r < kLanes; ++r) {
        float* row = buffer + r * stride_;
        std::memcpy(row, rows_in.data() + r * inputs, inputs * sizeof(float));
        row[inputs] = 1.0f;
        std::fill(row + inputs + 1, row + stride_, 0.0f);
      }
    }
    for (int s = recurrent_ ? bounded(steps) : 1; s > 0; --s) {
      kernel.rows(p, from, to, stride_);
      std::swap(from, to);
    }
    for (std::size_t r = 0; r < kLanes; ++r)
      for (std::size_t o = 0; o < outputs; ++o)
        rows_out[r * outputs + o] = from[r * stride_ + output_node_[o]];
  }
  for (; done < count; ++done)
    activate(in.subspan(static_cast<std::size_t>(done) * inputs, inputs),
             out.subspan(static_cast<std::size_t>(done) * outputs, outputs), scratch, steps);
}

void Network::activate_columns(std::span<const float> in, std::span<float> out, Scratch& scratch,
                               int steps) const {
  const kernels::Kernels& kernel = kernels::active();
  const auto inputs = static_cast<std::size_t>(inputs_);
  const std::size_t size = std::size_t{stride_} * kLanes;
  float* from = aligned(scratch.values, size * (recurrent_ ? 2 : 1));
  float* to = recurrent_ ? from + size : from;
  for (float* buffer = from; buffer <= to; buffer += size) {
    std::memcpy(buffer, in.data(), inputs * kLanes * sizeof(float));
    std::fill(buffer + inputs * kLanes, buffer + (inputs + 1) * kLanes, 1.0f);
    if (recurrent_) std::fill(buffer + (inputs + 1) * kLanes, buffer + size, 0.0f);
  }
  for (int s = recurrent_ ? bounded(steps) : 1; s > 0; --s) {
    kernel.columns(program(), from, to);
    std::swap(from, to);
  }
  for (std::size_t o = 0; o < output_node_.size(); ++o)
    std::memcpy(out.data() + o * kLanes, from + std::size_t{output_node_[o]} * kLanes,
                kLanes * sizeof(float));
  if (all_finite(in)) return;
  for (std::size_t c = 0; c < kLanes; ++c) {
    bool finite = true;
    for (std::size_t i = 0; i < inputs; ++i) finite &= std::isfinite(in[i * kLanes + c]);
    for (std::size_t o = 0; o < output_node_.size() && !finite; ++o)
      out[o * kLanes + c] = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace evograsp
