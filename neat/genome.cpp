#include "neat/genome.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace evograsp::neat {
namespace {

// Inserts at place k. What a column keeps in reserve is a sixteenth, not the double of std::vector.
template <class T>
void insert_at(std::vector<T>& column, std::size_t k, const T& value) {
  if (column.size() == column.capacity()) column.reserve(column.size() + column.size() / 16 + 4);
  column.insert(column.begin() + static_cast<std::ptrdiff_t>(k), value);
}

template <class T>
std::size_t bytes_of(const std::vector<T>& column) {
  return column.capacity() * sizeof(T);
}

}  // namespace

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
  const LinkEnds ends(source_node, target_node);
  bool found = false;
  for (const LinkEnds& late : late_ends_) found |= late == ends;
  return found || start_->contains(source_node, target_node);
}

void Genome::set_enabled(std::uint32_t i, bool on) {
  const std::uint64_t bit = std::uint64_t{1} << (i % 64);
  enabled_[i / 64] = on ? enabled_[i / 64] | bit : enabled_[i / 64] & ~bit;
}

void Genome::insert(const Link& link) {
  const auto place = std::upper_bound(late_innovation_.begin(), late_innovation_.end(), link.innovation);
  const auto k = static_cast<std::size_t>(place - late_innovation_.begin());
  const std::uint32_t i = start_links() + static_cast<std::uint32_t>(k);
  insert_at(late_innovation_, k, link.innovation);
  insert_at(late_ends_, k, LinkEnds(link.source, link.target));
  insert_at(weight_, i, link.weight);
  const std::uint32_t count = links();
  if (count > enabled_.size() * 64) insert_at(enabled_, enabled_.size(), std::uint64_t{0});
  for (std::uint32_t j = count - 1; j > i; --j) set_enabled(j, enabled(j - 1));
  set_enabled(i, link.enabled);
}

std::uint32_t Genome::late_node_place(std::uint32_t node) const {
  const auto place = std::lower_bound(hidden_.begin() + start_->hidden, hidden_.end(), node);
  if (place == hidden_.end() || *place != node) return computed_nodes();
  return outputs() + static_cast<std::uint32_t>(place - hidden_.begin());
}

void Genome::insert_hidden(std::uint32_t node, Activation f, float bias) {
  const auto j =
      static_cast<std::size_t>(std::lower_bound(hidden_.begin(), hidden_.end(), node) - hidden_.begin());
  insert_at(hidden_, j, node);
  insert_at(activation_, outputs() + j, static_cast<std::uint8_t>(f));
  insert_at(bias_, outputs() + j, bias);
}

std::size_t Genome::bytes() const {
  return sizeof(*this) + bytes_of(hidden_) + bytes_of(activation_) + bytes_of(bias_) +
         bytes_of(late_innovation_) + bytes_of(late_ends_) + bytes_of(weight_) + bytes_of(enabled_);
}

bool Genome::operator==(const Genome& other) const {
  return *start_ == *other.start_ && hidden_ == other.hidden_ && activation_ == other.activation_ &&
         bias_ == other.bias_ && late_innovation_ == other.late_innovation_ &&
         late_ends_ == other.late_ends_ && weight_ == other.weight_ && enabled_ == other.enabled_;
}

}  // namespace evograsp::neat
