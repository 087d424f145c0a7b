// The exported model computes what the network computes: read back and run by a small interpreter of our own.
#include "cli/onnx.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <string_view>

#include "common/network.h"
#include "common/random.h"

namespace evograsp::cli {
namespace {

// One protobuf field, read without a schema.
struct Field {
  int number;
  std::uint64_t value = 0;  // of numbers
  std::string_view bytes;   // of the rest
};

std::uint64_t varint(std::string_view& in) {
  std::uint64_t value = 0;
  for (int shift = 0;; shift += 7) {
    const auto byte = static_cast<unsigned char>(in.front());
    in.remove_prefix(1);
    value |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
    if (byte < 0x80) return value;
  }
}

std::vector<Field> fields(std::string_view in) {
  std::vector<Field> out;
  while (!in.empty()) {
    const std::uint64_t tag = varint(in);
    Field field{static_cast<int>(tag >> 3), 0, {}};
    field.value = varint(in);
    if ((tag & 7) == 2) {
      field.bytes = in.substr(0, field.value);
      in.remove_prefix(field.value);
    }
    out.push_back(field);
  }
  return out;
}

std::string_view bytes_of(std::string_view message, int number) {
  for (const Field& field : fields(message))
    if (field.number == number) return field.bytes;
  return {};
}

// Runs a model on one row, operator by operator.
class Interpreter {
 public:
  explicit Interpreter(std::string_view model) : graph_(bytes_of(model, 7)) {}

  std::vector<float> run(const std::vector<float>& observation) {
    rows_ = {{"observation", observation}};
    std::map<std::string, std::string_view> raw;
    for (const Field& f : fields(graph_))
      if (f.number == 5) raw[std::string(bytes_of(f.bytes, 8))] = bytes_of(f.bytes, 9);
    for (const Field& f : fields(graph_))
      if (f.number == 1) step(f.bytes, raw);
    return rows_.at("action");
  }

 private:
  template <class T>
  static std::vector<T> values(std::string_view raw) {
    std::vector<T> out(raw.size() / sizeof(T));
    std::memcpy(out.data(), raw.data(), raw.size());
    return out;
  }

  void step(std::string_view node, const std::map<std::string, std::string_view>& raw) {
    std::vector<std::string> in;
    for (const Field& f : fields(node))
      if (f.number == 1) in.emplace_back(f.bytes);
    const std::string op(bytes_of(node, 4));
    const std::vector<float>& a = rows_.at(in[0]);
    std::vector<float> out = a;
    if (op == "Gemm") {
      const auto weights = values<float>(raw.at(in[1]));
      out = values<float>(raw.at(in[2]));
      const std::size_t columns = out.size();
      EXPECT_EQ(weights.size(), a.size() * columns);
      for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < columns; ++k) out[k] += a[i] * weights[i * columns + k];
    } else if (op == "Concat") {
      const std::vector<float>& b = rows_.at(in[1]);
      out.insert(out.end(), b.begin(), b.end());
    } else if (op == "Gather") {
      out.clear();
      for (const auto column : values<std::int64_t>(raw.at(in[1])))
        out.push_back(a.at(static_cast<std::size_t>(column)));
    } else {
      for (float& x : out) x = apply(op, x);
    }
    rows_[std::string(bytes_of(node, 2))] = std::move(out);
  }

  static float apply(const std::string& op, float x) {
    if (op == "Sigmoid") return 1 / (1 + std::exp(-x));
    if (op == "Tanh") return std::tanh(x);
    if (op == "Relu") return std::max(x, 0.0F);
    if (op == "Sin") return std::sin(x);
    if (op == "Abs") return std::abs(x);
    if (op == "Mul") return x * x;
    if (op == "Neg") return -x;
    if (op == "Exp") return std::exp(x);
    if (op == "Greater") return x > 0 ? 1.0F : 0.0F;
    EXPECT_TRUE(op == "Identity" || op == "Cast") << op;
    return x;
  }

  std::string_view graph_;
  std::map<std::string, std::vector<float>> rows_;
};

// Feed-forward, every activation function, links from inputs, bias and earlier nodes.
proto::Champion random_champion(std::uint64_t seed) {
  Random random(seed, Purpose::kTestHarness);
  constexpr std::uint32_t kInputs = 6, kNodes = 24;
  proto::Champion champion;
  proto::Network& network = *champion.mutable_network();
  network.set_version(1);
  network.set_inputs(kInputs);
  network.set_outputs(7);
  for (std::uint32_t i = 0; i < kNodes; ++i) {
    network.add_activation(i % 8);
    network.add_bias(static_cast<float>(random.uniform() - 0.5));
    network.add_first_link(static_cast<std::uint32_t>(network.source_size()));
    for (std::uint32_t source = 0; source < kInputs + 1 + i; ++source) {
      if (!random.chance(0.4)) continue;
      network.add_source(source);
      network.add_weight(static_cast<float>(random.uniform() - 0.5));
    }
  }
  network.add_first_link(static_cast<std::uint32_t>(network.source_size()));
  for (std::uint32_t o = 0; o < 7; ++o) network.add_output_node(kInputs + kNodes - 2 * o);
  return champion;
}

TEST(Onnx, ComputesWhatTheNetworkComputes) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const proto::Champion champion = random_champion(seed);
    const auto network = Network::from_proto(champion.network());
    ASSERT_TRUE(network) << network.error().message;
    const auto model = to_onnx(champion);
    ASSERT_TRUE(model) << model.error().message;
    Random random(seed, Purpose::kTestHarness, 1);
    std::vector<float> in(6), out(7);
    for (float& x : in) x = static_cast<float>(random.uniform());
    Network::Scratch scratch;
    network->activate(in, out, scratch);
    const std::vector<float> theirs = Interpreter(*model).run(in);
    ASSERT_EQ(theirs.size(), out.size());
    for (std::size_t i = 0; i < out.size(); ++i)
      EXPECT_NEAR(theirs[i], out[i], 2e-5) << "seed " << seed << ", output " << i;
  }
}

TEST(Onnx, ARecurrentNetworkIsRefused) {
  proto::Champion champion = random_champion(1);
  champion.mutable_network()->set_recurrent(true);
  const auto model = to_onnx(champion);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, ErrorCode::kUnsupported);
}

TEST(Onnx, SaysWhatItsColumnsMean) {
  const auto model = to_onnx(random_champion(1));
  ASSERT_TRUE(model);
  EXPECT_THAT(*model, ::testing::HasSubstr("row by row from the top left"));
  EXPECT_THAT(*model, ::testing::HasSubstr("observation"));
}

}  // namespace
}  // namespace evograsp::cli
