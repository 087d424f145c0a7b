// What a worker has been sent and keeps, so that it is not sent again. Master and worker do the same
// bookkeeping over the same messages in the same order, so that they agree without a word about it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>
#include <zmq.hpp>

#include "common/result.h"
#include "proto/wire.pb.h"

namespace evograsp {

// The networks that a worker keeps of the work at hand: the last ones sent, kMostNetworks and kMostBytes of
// them, the newest always. Few, because the tasks of one network follow each other.
class NetworkMemory {
 public:
  static constexpr std::size_t kMostNetworks = 16, kMostBytes = 4 << 20;

  bool has(std::uint64_t network) const;
  // A second handle on what was kept; the network must be there.
  zmq::message_t share(std::uint64_t network);
  // bytes: the frame, or an empty one where only the fact counts; size: the frame's.
  void add(std::uint64_t network, zmq::message_t bytes, std::size_t size);
  void clear();

 private:
  struct Kept {
    std::uint64_t network;
    std::size_t size;
    zmq::message_t bytes;
  };
  std::deque<Kept> kept_;  // the oldest first
  std::size_t bytes_ = 0;
};

// The worker's side: makes whole again what the master left out. Not thread-safe.
class TaskMemory {
 public:
  // Leaves in task.trial() the trials it names and in `body` one frame for each network. kInvalid: it builds
  // on something that was never sent, or counts wrongly.
  Status complete(proto::Task& task, std::vector<zmq::message_t>& body);
  // A new session begins.
  void clear();

 private:
  Status complete_networks(const proto::Task& task, std::vector<zmq::message_t>& body);

  std::vector<proto::TrialKey> trials_;
  NetworkMemory networks_;
};

}  // namespace evograsp
