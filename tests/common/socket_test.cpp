#include "common/socket.h"

#include <gtest/gtest.h>

namespace evograsp {
namespace {

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
