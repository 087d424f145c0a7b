#include "neat/hyperneat.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace evograsp::neat {
namespace {

constexpr std::uint32_t kBatch = Network::kColumns;
constexpr std::uint32_t kExtras = 4;  // click a, b and box w, h

// Point i of n over [-1, 1]; exactly antisymmetric.
float coordinate(std::uint32_t i, std::uint32_t n) {
  if (n < 2) return 0;
  return static_cast<float>(2 * static_cast<int>(i) - static_cast<int>(n - 1)) / static_cast<float>(n - 1);
}

// What a CPPN is asked: x1, y1, x2, y2 and the distance of kBatch pairs of points.
struct Batch {
  std::array<float, kCppnInputs* kBatch> in = {};
  float* x1() { return in.data(); }
  float* y1() { return in.data() + kBatch; }
  float* x2() { return in.data() + 2 * kBatch; }
  float* y2() { return in.data() + 3 * kBatch; }

  void set_distances() {
    for (std::uint32_t k = 0; k < kBatch; k += 4) {
      const __m128 dx = _mm_sub_ps(_mm_loadu_ps(x2() + k), _mm_loadu_ps(x1() + k));
      const __m128 dy = _mm_sub_ps(_mm_loadu_ps(y2() + k), _mm_loadu_ps(y1() + k));
      const __m128 square = _mm_add_ps(_mm_mul_ps(dx, dx), _mm_mul_ps(dy, dy));
      _mm_storeu_ps(in.data() + 4 * kBatch + k, _mm_sqrt_ps(square));
    }
  }
};

float limited(float w) {
  return std::min(std::max(w, -1.0f), 1.0f);
}

}  // namespace

std::uint32_t Substrate::add_sheet(std::uint32_t columns, std::uint32_t rows, std::uint32_t first_node) {
  Sheet sheet{.first_node = first_node, .count = columns * rows, .x = {}, .y = {}};
  for (std::uint32_t r = 0; r < rows; ++r)
    for (std::uint32_t c = 0; c < columns; ++c) {
      sheet.x.push_back(coordinate(c, columns));
      sheet.y.push_back(coordinate(r, rows));
    }
  sheet_.push_back(std::move(sheet));
  return static_cast<std::uint32_t>(sheet_.size() - 1);
}

// Sheets and groups of links. Within a target, groups come in the order of their sources' node numbers.
void Substrate::add_layers(const proto::HyperNeatConfig& config) {
  const std::uint32_t depth = add_sheet(config.input_columns(), config.input_rows(), 0);
  const std::uint32_t extras = add_sheet(2, 2, sheet_[depth].count);
  std::uint32_t next_node = inputs_ + 1, last = depth;
  const auto add_hidden = [&](std::uint32_t columns, std::uint32_t rows) {
    const std::uint32_t sheet = add_sheet(columns, rows, next_node);
    next_node += columns * rows;
    group_.push_back({last, sheet, {}});
    if (last == depth) group_.push_back({extras, sheet, {}});
    bias_sheet_.push_back(sheet);
    last = sheet;
  };
  for (const proto::SubstrateSheet& sheet : config.hidden_sheet()) add_hidden(sheet.columns(), sheet.rows());
  if (config.hidden_sheet_size() == 0) add_hidden(10, 8);
  const std::uint32_t out = add_sheet(outputs_, 1, next_node);
  group_.push_back({extras, out, {}});
  group_.push_back({last, out, {}});
  bias_sheet_.push_back(out);
  if (!config.bias_output()) bias_sheet_.clear();
}

Result<Substrate> Substrate::make(const proto::NeatConfig& config) {
  const proto::HyperNeatConfig& hyper = config.hyperneat();
  const auto bad = [](const std::string& what) {
    return fail(ErrorCode::kInvalid, "neat.hyperneat: " + what);
  };
  if (config.recurrent()) return bad("substrates are feed-forward: recurrent must be false");
  const std::uint64_t columns = hyper.input_columns(), rows = hyper.input_rows();
  if (columns < 1 || rows < 1 || columns > 1000 || rows > 1000)
    return bad("the input sheet must be 1 to 1000 wide and high");
  if (hyper.outputs() < 1 || hyper.outputs() > 1000) return bad("outputs must be 1 to 1000");
  if (!(hyper.link_threshold() >= 0 && hyper.link_threshold() <= 1))
    return bad("link_threshold must be 0 to 1");
  if (!(hyper.max_weight() > 0 && hyper.max_weight() <= static_cast<double>(Network::kMaxWeight)))
    return bad("max_weight must be above 0, at most 1048576");
  std::uint64_t before = columns * rows, links = 0, nodes = before;
  for (const proto::SubstrateSheet& sheet : hyper.hidden_sheet()) {
    const std::uint64_t count = std::uint64_t{sheet.columns()} * sheet.rows();
    if (count < 1 || count > 1'000'000) return bad("a hidden sheet must have 1 to 1000000 nodes");
    links += (before + kExtras) * count;
    nodes += before = count;
  }
  if (hyper.hidden_sheet_size() == 0) links = (before + kExtras) * 80;
  links += (before + kExtras) * hyper.outputs();
  if (links > Network::kMaxLinks || nodes + 2000 > Network::kMaxNodes)
    return bad("the substrate could have " + std::to_string(links) + " links; 4194304 are allowed");

  Substrate substrate;
  substrate.inputs_ = static_cast<std::uint32_t>(columns * rows) + kExtras;
  substrate.outputs_ = hyper.outputs();
  substrate.threshold_ = static_cast<float>(hyper.link_threshold());
  substrate.max_weight_ = static_cast<float>(hyper.max_weight());
  substrate.activation_ = static_cast<std::uint8_t>(hyper.activation());
  substrate.add_layers(hyper);
  return substrate;
}

// Asks the CPPN about every pair of a group: target by target, sources in order.
void Substrate::paint(Group& group, const Network& cppn) {
  const Sheet &from = sheet_[group.from], &to = sheet_[group.to];
  const std::size_t pairs = std::size_t{from.count} * to.count;
  group.painted.resize((pairs + kBatch - 1) / kBatch * kBatch);
  Batch batch;
  std::uint32_t source = 0, target = 0;
  for (std::size_t p = 0; p < pairs; p += kBatch) {
    const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(kBatch, pairs - p));
    for (std::uint32_t k = 0; k < count;) {
      const std::uint32_t run = std::min(count - k, from.count - source);
      std::copy_n(&from.x[source], run, batch.x1() + k);
      std::copy_n(&from.y[source], run, batch.y1() + k);
      std::fill_n(batch.x2() + k, run, to.x[target]);
      std::fill_n(batch.y2() + k, run, to.y[target]);
      k += run;
      source += run;
      if (source == from.count) source = 0, ++target;
    }
    batch.set_distances();
    cppn.activate_columns(batch.in, std::span(group.painted).subspan(p, kBatch), scratch_);
  }
}

// Links of one group into one point of its target sheet, written without a branch a link: how many there will
// be is not known, room for all is there.
void Substrate::append_links(const Group& group, std::uint32_t point) {
  const Sheet& from = sheet_[group.from];
  const float gain = threshold_ < 1 ? max_weight_ / (1 - threshold_) : 0;
  const float* painted = &group.painted[std::size_t{point} * from.count];
  std::size_t end = source_.size();
  source_.resize(end + from.count);
  weight_.resize(end + from.count);
  for (std::uint32_t i = 0; i < from.count; ++i) {
    const float w = limited(painted[i]), size = std::fabs(w);
    source_[end] = from.first_node + i;
    weight_[end] = std::copysign((size - threshold_) * gain, w);
    end += size > threshold_;
  }
  source_.resize(end);
  weight_.resize(end);
}

// The points of a sheet that computes: their links, group by group.
void Substrate::express_sheet(std::uint32_t sheet) {
  for (std::size_t g = 0; g < group_.size(); ++g)
    if (group_[g].to == sheet) paint(group_[g], cppn_[g]);
  for (std::uint32_t point = 0; point < sheet_[sheet].count; ++point) {
    for (const Group& group : group_)
      if (group.to == sheet) append_links(group, point);
    first_link_.push_back(static_cast<std::uint32_t>(source_.size()));
    activations_.push_back(activation_);
  }
  append_biases(sheet);
}

void Substrate::append_biases(std::uint32_t sheet) {
  const Sheet& points = sheet_[sheet];
  const auto output = std::find(bias_sheet_.begin(), bias_sheet_.end(), sheet);
  if (output == bias_sheet_.end()) return bias_.resize(bias_.size() + points.count, 0.0f);
  const Network& cppn = cppn_[group_.size() + static_cast<std::size_t>(output - bias_sheet_.begin())];
  Batch batch;
  std::array<float, kBatch> out;
  for (std::uint32_t k = 0; k < points.count; k += kBatch) {
    const std::uint32_t count = std::min(kBatch, points.count - k);
    std::copy_n(&points.x[k], count, batch.x2());
    std::copy_n(&points.y[k], count, batch.y2());
    batch.set_distances();
    cppn.activate_columns(batch.in, out, scratch_);
    for (std::uint32_t i = 0; i < count; ++i) bias_.push_back(limited(out[i]) * max_weight_);
  }
}

Network Substrate::express(const Genome& cppn, GenomeCompiler& compiler) {
  cppn_.clear();  // one network an output: only what that output needs is computed
  for (std::uint32_t o = 0; o < cppn_outputs(); ++o)
    cppn_.push_back(Network::from_sound_columns(compiler.columns(cppn, static_cast<int>(o))));
  first_link_.assign(1, 0);
  source_.clear();
  weight_.clear();
  bias_.clear();
  activations_.clear();
  output_node_.clear();
  for (std::uint32_t sheet = 2; sheet < sheet_.size(); ++sheet) express_sheet(sheet);  // 0: depth, 1: extras
  for (std::uint32_t o = 0; o < outputs_; ++o) output_node_.push_back(sheet_.back().first_node + o);
  return Network::from_sound_columns({.inputs = inputs_,
                                      .recurrent = false,
                                      .activation = activations_,
                                      .bias = bias_,
                                      .first_link = first_link_,
                                      .source = source_,
                                      .weight = weight_,
                                      .output_node = output_node_});
}

}  // namespace evograsp::neat
