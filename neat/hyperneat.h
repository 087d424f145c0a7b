// HyperNEAT (Stanley, D'Ambrosio and Gauci 2009): genomes are CPPNs, small networks that say the weight of
// each link of a large one, the substrate, from where its ends lie.
//
// Sheets of the substrate, each spread over [-1, 1] x [-1, 1], x to the right and y downward:
//   depth    input_columns x input_rows, row by row from the top left
//   extras   click a (-1, -1), click b (1, -1), box w (-1, 1), box h (1, 1): x tells the axis, y what it is
//   hidden   columns x rows, in the config's order
//   outputs  one row
// Groups of links, each with a CPPN output of its own (so that a click need not weigh what a pixel beside it
// does): depth to the first hidden sheet, extras to it, each hidden sheet to the next, the last to the
// outputs, extras to the outputs. Then, with bias_output, a CPPN output for the biases of each hidden sheet
// and of the outputs.
//
// CPPN inputs: x1, y1 (source), x2, y2 (target) and the distance between them; for biases the source is (0,
// 0). What it says, w limited to [-1, 1], is a link of weight sign(w) (|w| - t) / (1 - t) max_weight if |w|
// is above the threshold t, and none otherwise; a bias is w max_weight.
#pragma once

#include <cstdint>
#include <vector>

#include "common/network.h"
#include "common/result.h"
#include "neat/genome.h"
#include "neat/genome_compiler.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

inline constexpr std::uint32_t kCppnInputs = 5;

class Substrate {
 public:
  // config.hyperneat decides all. kInvalid when it is too large for a network.
  static Result<Substrate> make(const proto::NeatConfig& config);

  std::uint32_t inputs() const { return inputs_; }
  std::uint32_t outputs() const { return outputs_; }
  std::uint32_t cppn_outputs() const {
    return static_cast<std::uint32_t>(group_.size() + bias_sheet_.size());
  }

  // The network that a CPPN describes; `compiler` makes networks of the CPPN itself. Not thread-safe.
  Network express(const Genome& cppn, GenomeCompiler& compiler);

 private:
  struct Sheet {
    std::uint32_t first_node = 0;  // node number of its first point in the network
    std::uint32_t count = 0;
    std::vector<float> x, y;
  };
  struct Group {
    std::uint32_t from = 0, to = 0;  // sheets
    std::vector<float> painted;      // what the CPPN says of each pair: working storage
  };

  std::uint32_t add_sheet(std::uint32_t columns, std::uint32_t rows, std::uint32_t first_node);
  void add_layers(const proto::HyperNeatConfig& config);
  void express_sheet(std::uint32_t sheet);
  void paint(Group& group, const Network& cppn);
  void append_links(const Group& group, std::uint32_t point);
  void append_biases(std::uint32_t sheet);

  std::uint32_t inputs_ = 0, outputs_ = 0;
  float threshold_ = 0, max_weight_ = 0;
  std::uint8_t activation_ = 0;
  std::vector<Sheet> sheet_;
  std::vector<Group> group_;               // by CPPN output
  std::vector<std::uint32_t> bias_sheet_;  // sheet of each CPPN output after the groups'
  // Working storage.
  std::vector<Network> cppn_;
  Network::Scratch scratch_;
  std::vector<float> bias_, weight_;
  std::vector<std::uint32_t> first_link_, source_, output_node_;
  std::vector<std::uint8_t> activations_;
};

}  // namespace evograsp::neat
