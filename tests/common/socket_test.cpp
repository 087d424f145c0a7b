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

// A peer that sends faster than it is read fills its own memory, not the master's.
TEST(Router, HoldsNoMoreOfAPeerThanItsBound) {
  zmq::context_t context(1);
  SocketOptions options;
  options.max_frame_bytes = 1 << 20;
  options.queue_bytes = 8 << 20;
  auto router = make_router(context, options);
  ASSERT_TRUE(router);
  const std::string address = *bind(*router, "tcp://127.0.0.1:*");
  SocketOptions patient;
  patient.high_water = 64;
  auto dealer = make_dealer(context, address, patient);
  ASSERT_TRUE(dealer);
  dealer->set(zmq::sockopt::sndtimeo, 500);
  const std::string mebibyte(1 << 20, 'x');
  int taken = 0;
  while (taken < 500 && dealer->send(zmq::buffer(mebibyte))) ++taken;
  EXPECT_GE(taken, 64) << "the dealer's own queue";
  EXPECT_LE(taken, 64 + 8 + 20) << "beside what the two hold, what the kernel holds of a connection";
}

}  // namespace
}  // namespace evograsp
