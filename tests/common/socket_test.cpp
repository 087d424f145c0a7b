#include "common/socket.h"

#include <gtest/gtest.h>

#include <optional>

namespace evograsp {
namespace {

// A worker that loses its master watches a new socket at once, often at the address of the old one.
TEST(DisconnectMonitor, CanBeMadeAnewAtOnceInTheSamePlace) {
  zmq::context_t context(1);
  std::optional<DisconnectMonitor> monitor;
  for (int i = 0; i < 200; ++i) {
    zmq::socket_t socket(context, zmq::socket_type::dealer);
    ASSERT_NO_THROW(monitor.emplace(context, socket)) << "after " << i << " monitors";
    EXPECT_TRUE(monitor->drain().empty());
    monitor.reset();
  }
}

}  // namespace
}  // namespace evograsp
