// What single ranges cannot say about a config: values that must fit each other.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "proto/config.pb.h"

namespace evograsp {

constexpr std::size_t kLongestRunName = 100;  // bytes

// Calls complain(dotted path of the value to change, message) for each contradiction. The config has its
// defaults written out.
void check_config(const proto::Config& config,
                  const std::function<void(const std::string& path, const std::string& message)>& complain);

}  // namespace evograsp
