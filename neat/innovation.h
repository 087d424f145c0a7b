// Historical markings: who gets which number (Stanley and Miikkulainen 2002, section 3.2).
#pragma once

#include <cstdint>
#include <unordered_map>

namespace evograsp::neat {

// Hands out innovations and node numbers. The same structural mutation gets the same numbers within one
// generation; in a later generation it gets new ones, so that a link that was split, enabled again and split
// again receives a second node. Numbers depend on the order of the calls alone: children ask in order.
class Innovations {
 public:
  struct Split {
    std::uint32_t node = 0;      // the new hidden node
    std::uint32_t link_in = 0;   // innovation of source -> node
    std::uint32_t link_out = 0;  // innovation of node -> target
  };

  Innovations(std::uint32_t next_innovation, std::uint32_t next_node)
      : next_innovation_(next_innovation), next_node_(next_node) {}

  // Forgets which mutations this generation has seen; numbers go on.
  void next_generation() {
    links_.clear();
    splits_.clear();
  }
  std::uint32_t link(std::uint32_t source, std::uint32_t target) {
    const auto [entry, is_new] = links_.try_emplace(std::uint64_t{source} << 32 | target, next_innovation_);
    next_innovation_ += is_new;
    return entry->second;
  }
  // Of the link with this innovation.
  Split split(std::uint32_t innovation) {
    const auto [entry, is_new] =
        splits_.try_emplace(innovation, Split{next_node_, next_innovation_, next_innovation_ + 1});
    next_node_ += is_new;
    next_innovation_ += 2 * is_new;
    return entry->second;
  }

  std::uint32_t next_innovation() const { return next_innovation_; }
  std::uint32_t next_node() const { return next_node_; }

 private:
  std::uint32_t next_innovation_;
  std::uint32_t next_node_;
  // Looked up, never walked through.
  std::unordered_map<std::uint64_t, std::uint32_t> links_;  // lookup only
  std::unordered_map<std::uint32_t, Split> splits_;         // lookup only
};

}  // namespace evograsp::neat
