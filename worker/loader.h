// From a master's Welcome to a simulator: which assets are missing, and the simulator once all are here.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "proto/bundle.pb.h"
#include "proto/wire.pb.h"
#include "sim/simulator.h"

namespace evograsp::worker {

// Not thread-safe. Bundles stay between experiments: a master that comes back serves the same ones.
class Loader {
 public:
  // An error when the fingerprint is not what this build makes of the experiment, for it would simulate
  // something else, and for more than 256 objects.
  Status begin(const proto::Experiment& experiment);
  const proto::Experiment& experiment() const { return experiment_; }
  // Ids not here yet; empty: build() may be called.
  std::vector<std::string> missing() const;
  // Checks the bytes against their id, and what all objects take together.
  Status accept(const std::string& id, std::string_view packed);
  // Takes long (meshes): not for the thread that answers heartbeats.
  Result<std::shared_ptr<const sim::Simulator>> build() const;

 private:
  proto::Experiment experiment_;
  std::map<std::string, proto::ObjectBundle> objects_;
  std::map<std::string, proto::HandBundle> hands_;
};

}  // namespace evograsp::worker
