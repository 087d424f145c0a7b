// A thousand workers that come, take work and vanish leave nothing behind: no descriptor, no thread, no
// session.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/server/cluster.h"
#include "tests/server/raw_peer.h"

namespace evograsp::testing {
namespace {

std::size_t entries(const char* folder) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) count += entry.path().empty() ? 0 : 1;
  return count;
}

// One worker's life, from a connection of its own to a death without a word.
bool come_and_go(const std::string& endpoint, int number) {
  zmq::context_t context(1);
  RawPeer peer(context, endpoint);
  if (!peer.join("w" + std::to_string(number))) return false;
  const auto task = peer.next();
  return task && task->has_task();
}

TEST(Leaks, AThousandReconnectsLeaveNoDescriptorAndNoThread) {
  constexpr int kLives = 1000, kWarmUp = 50;
  zmq::context_t context(1);
  CountingSink sink;
  auto options = noop_options();
  options.scheduler.poison_strikes = 1000000;  // nobody says that a task has started, nothing is to blame
  auto dispatcher = server::Dispatcher::create(context, options, sink);
  ASSERT_TRUE(dispatcher) << dispatcher.error().message;
  const std::string endpoint = (*dispatcher)->endpoints()[0];
  give_noop_work(**dispatcher, 100, 1, 0);

  int number = 0;
  while (number < kWarmUp) ASSERT_TRUE(come_and_go(endpoint, number++));
  const auto gone = [&] { return (*dispatcher)->view().workers.empty(); };
  ASSERT_TRUE(eventually(gone));
  const std::size_t descriptors = entries("/proc/self/fd"), threads = entries("/proc/self/task");

  while (number < kWarmUp + kLives) ASSERT_TRUE(come_and_go(endpoint, number++)) << "after " << number;
  ASSERT_TRUE(eventually(gone));
  EXPECT_TRUE(eventually([&] { return entries("/proc/self/fd") <= descriptors + 1; }))
      << entries("/proc/self/fd") << " descriptors, " << descriptors << " before";
  EXPECT_EQ(entries("/proc/self/task"), threads);
  // The view is of a moment ago.
  EXPECT_TRUE(eventually([&] { return (*dispatcher)->view().lost >= kWarmUp + kLives; }))
      << "not every loss was noticed: " << (*dispatcher)->view().lost;
}

}  // namespace
}  // namespace evograsp::testing
