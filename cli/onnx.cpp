#include "cli/onnx.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/activation.h"
#include "common/network.h"
#include "common/version.h"

namespace evograsp::cli {
namespace {

static_assert(std::endian::native == std::endian::little, "raw_data is little-endian");

// Protobuf's wire format for the few messages of onnx.proto that are needed; the field numbers are that
// file's.
class Message {
 public:
  Message& number(int field, std::uint64_t value) {
    varint(static_cast<std::uint64_t>(field) << 3);
    varint(value);
    return *this;
  }
  Message& text(int field, std::string_view value) {
    varint(static_cast<std::uint64_t>(field) << 3 | 2);
    varint(value.size());
    bytes_.append(value);
    return *this;
  }
  Message& message(int field, const Message& value) { return text(field, value.bytes_); }
  const std::string& bytes() const { return bytes_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<char>(value | 0x80));
    bytes_.push_back(static_cast<char>(value));
  }
  std::string bytes_;
};

enum DataType { kFloat = 1, kInt64 = 7 };

template <class T>
Message tensor(const std::string& name, DataType type, const std::vector<std::uint64_t>& shape,
               const std::vector<T>& values) {
  Message out;
  for (const std::uint64_t size : shape) out.number(1, size);
  out.number(2, type).text(8, name);
  out.text(9, {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
  return out;
}

Message attribute(const std::string& name, std::uint64_t value) {
  constexpr int kInt = 2;
  return Message().text(1, name).number(3, value).number(20, kInt);
}

Message value_info(const std::string& name, std::uint64_t columns) {
  Message shape;
  shape.message(1, Message().text(2, "N")).message(1, Message().number(1, columns));
  const Message type = Message().number(1, kFloat).message(2, shape);
  return Message().text(1, name).message(2, Message().message(1, type));
}

class Graph {
 public:
  explicit Graph(const proto::Network& network) : network_(network) {}

  Message build() {
    place_.assign(nodes(), 0);
    columns_ = network_.inputs();
    last_ = "observation";
    for (const auto& [key, members] : groups()) add_group(static_cast<Activation>(key.second), members);
    std::vector<std::int64_t> wanted;
    for (const std::uint32_t node : network_.output_node()) wanted.push_back(column(node));
    graph_.message(5, tensor("columns", kInt64, {wanted.size()}, wanted));
    add("Gather", {last_, "columns"}, "action", {attribute("axis", 1)});
    graph_.text(2, "evograsp").message(11, value_info("observation", network_.inputs()));
    graph_.message(12, value_info("action", network_.outputs()));
    return graph_;
  }

 private:
  using Key = std::pair<std::uint32_t, std::uint32_t>;  // level, activation

  std::size_t nodes() const { return static_cast<std::size_t>(network_.activation_size()); }
  bool is_computed(std::uint32_t node) const { return node > network_.inputs(); }
  std::uint32_t index_of(std::uint32_t node) const { return node - network_.inputs() - 1; }
  bool is_bias(std::uint32_t node) const { return node == network_.inputs(); }
  std::int64_t column(std::uint32_t node) const { return is_computed(node) ? place_[index_of(node)] : node; }

  // Nodes that can be computed together: all they read is of lower levels.
  std::map<Key, std::vector<std::uint32_t>> groups() const {
    std::vector<std::uint32_t> level(nodes(), 0);
    std::map<Key, std::vector<std::uint32_t>> groups;
    for (std::uint32_t i = 0; i < nodes(); ++i) {
      for (std::uint32_t k = network_.first_link(static_cast<int>(i)); k < end_link(i); ++k) {
        const std::uint32_t source = network_.source(static_cast<int>(k));
        if (is_computed(source)) level[i] = std::max(level[i], level[index_of(source)] + 1);
      }
      groups[{level[i], network_.activation(static_cast<int>(i))}].push_back(i);
    }
    return groups;
  }
  std::uint32_t end_link(std::uint32_t i) const { return network_.first_link(static_cast<int>(i) + 1); }

  void add(const std::string& op, const std::vector<std::string>& inputs, const std::string& output,
           const std::vector<Message>& attributes = {}) {
    Message node;
    for (const std::string& input : inputs) node.text(1, input);
    node.text(2, output).text(3, output + "_node").text(4, op);
    for (const Message& one : attributes) node.message(5, one);
    graph_.message(1, node);
  }

  // last = Concat(last, f(Gemm(last, weights, bias))).
  void add_group(Activation kind, const std::vector<std::uint32_t>& members) {
    const std::string name = "group" + std::to_string(count_++);
    const float scale =
        kind == Activation::kSteepSigmoid ? 4.9F : 1.0F;  // ONNX's sigmoid is 1 / (1 + exp(-x))
    std::vector<float> weights(columns_ * members.size()), bias;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const std::uint32_t i = members[m];
      bias.push_back(scale * network_.bias(static_cast<int>(i)));
      for (std::uint32_t k = network_.first_link(static_cast<int>(i)); k < end_link(i); ++k) {
        const std::uint32_t source = network_.source(static_cast<int>(k));
        const float weight = scale * network_.weight(static_cast<int>(k));
        if (is_bias(source))
          bias[m] += weight;
        else
          weights[static_cast<std::size_t>(column(source)) * members.size() + m] += weight;
      }
    }
    graph_.message(5, tensor(name + "_weights", kFloat, {columns_, members.size()}, weights));
    graph_.message(5, tensor(name + "_bias", kFloat, {members.size()}, bias));
    add("Gemm", {last_, name + "_weights", name + "_bias"}, name + "_sum");
    add_activation(kind, name);
    add("Concat", {last_, name + "_value"}, name + "_all", {attribute("axis", 1)});
    for (const std::uint32_t i : members) place_[i] = static_cast<std::int64_t>(columns_++);
    last_ = name + "_all";
  }

  void add_activation(Activation kind, const std::string& name) {
    const std::string sum = name + "_sum", value = name + "_value";
    switch (kind) {
      case Activation::kSteepSigmoid:
        return add("Sigmoid", {sum}, value);
      case Activation::kTanh:
        return add("Tanh", {sum}, value);
      case Activation::kRelu:
        return add("Relu", {sum}, value);
      case Activation::kLinear:
        return add("Identity", {sum}, value);
      case Activation::kSine:
        return add("Sin", {sum}, value);
      case Activation::kAbs:
        return add("Abs", {sum}, value);
      case Activation::kGaussian:
        add("Mul", {sum, sum}, name + "_square");
        add("Neg", {name + "_square"}, name + "_negated");
        return add("Exp", {name + "_negated"}, value);
      case Activation::kStep:
        graph_.message(5, tensor(name + "_zero", kFloat, {1}, std::vector<float>{0}));
        add("Greater", {sum, name + "_zero"}, name + "_above");
        return add("Cast", {name + "_above"}, value, {attribute("to", kFloat)});
    }
  }

  const proto::Network& network_;
  Message graph_;
  std::vector<std::int64_t> place_;  // of each computed node: its column in last_
  std::uint64_t columns_ = 0;        // of last_
  std::string last_;                 // every value so far, side by side
  int count_ = 0;
};

Message metadata(const std::string& key, const std::string& value) {
  return Message().text(1, key).text(2, value);
}

}  // namespace

Result<std::string> to_onnx(const proto::Champion& champion) {
  const proto::Network& network = champion.network();
  if (const auto checked = Network::from_proto(network); !checked) return tl::unexpected(checked.error());
  if (network.recurrent())
    return fail(ErrorCode::kUnsupported,
                "the network is recurrent: ONNX export is for feed-forward networks");
  std::string experiment;
  google::protobuf::TextFormat::PrintToString(champion.experiment(), &experiment);
  const proto::CameraConfig& camera = champion.experiment().camera();
  const std::string features = camera.feature_size() > 0 ? ", then camera.feature in its order" : "";
  const std::string frame =
      camera.object_frame()
          ? "; all in axes turned about the vertical, x across the main axis that AXIS tells"
          : "";
  Message model;
  model.number(1, 8).text(2, "evograsp").text(3, kVersion).message(7, Graph(network).build());
  model.message(8, Message().text(1, "").number(2, 13));
  model.message(
      14, metadata("observation",
                   "depth samples in [0, 1], row by row from the top left (1: no return), then the click's "
                   "a, b and the box's w, h in [0, 1] of the image" +
                       features));
  model.message(
      14, metadata("action",
                   "position x, y, z in units of the workspace's half sizes, from the anchor (the "
                   "target's centre with the box, else the workspace's), rotation axis x, y, z (any length; "
                   "none: no rotation) and angle in units of pi, applied to the home orientation" +
                       frame));
  model.message(14, metadata("experiment", experiment));
  model.message(14, metadata("fingerprint", champion.fingerprint()));
  return model.bytes();
}

}  // namespace evograsp::cli
