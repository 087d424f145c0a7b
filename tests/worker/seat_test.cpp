// The names that workers have who were given none.
#include "worker/seat.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>

namespace evograsp::worker {
namespace {

const std::string kMaster = "test:" + std::to_string(getpid());  // nobody else's

TEST(Seat, NoTwoThatRunShareOneAndTheNextTakesWhatIsFree) {
  std::optional<Seat> first(Seat::take(kMaster));
  const Seat second = Seat::take(kMaster);
  const std::string name = first->name();
  EXPECT_NE(name, second.name());
  EXPECT_EQ(name.rfind(host_name() + "-", 0), 0U) << name;
  first.reset();
  EXPECT_EQ(Seat::take(kMaster).name(), name);
  EXPECT_NE(Seat::take(kMaster + "x").name(), name) << "workers of two masters get in each other's way";
}

TEST(Seat, OfAKilledProcessIsThatOfTheNext) {
  int channel[2];
  ASSERT_EQ(pipe(channel), 0);
  const pid_t child = fork();
  if (child == 0) {
    const Seat seat = Seat::take(kMaster);
    if (write(channel[1], seat.name().data(), seat.name().size()) < 0) _exit(1);
    for (;;) pause();
  }
  char text[256] = {};
  ASSERT_GT(read(channel[0], text, sizeof text - 1), 0);
  EXPECT_NE(Seat::take(kMaster).name(), text) << "two at a time";
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(Seat::take(kMaster).name(), text);
  close(channel[0]);
  close(channel[1]);
}

}  // namespace
}  // namespace evograsp::worker
