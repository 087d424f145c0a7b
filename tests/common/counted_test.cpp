#include "common/counted.h"

#include <gtest/gtest.h>

namespace evograsp {
namespace {

TEST(Counted, OneIsNoPlural) {
  EXPECT_EQ(counted(0, "task"), "0 tasks");
  EXPECT_EQ(counted(1, "task"), "1 task");
  EXPECT_EQ(counted(2, "task"), "2 tasks");
}

}  // namespace
}  // namespace evograsp
