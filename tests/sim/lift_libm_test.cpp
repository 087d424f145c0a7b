// Bullet must get our trigonometry, or lifts depend on the processor.
#include "sim/lift_libm.h"

#include <LinearMath/btScalar.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/det_math.h"

namespace evograsp::sim {
namespace {

TEST(LiftLibm, SharedLibrariesAreBoundToThisProgramsFunctions) {
  keep_own_libm();
  void* const program = dlopen(nullptr, RTLD_NOW);
  ASSERT_NE(program, nullptr);
  for (const char* name : {"sin", "cos", "sincos", "acos", "asin", "atan2"}) {
    void* const bound = dlsym(program, name);
    Dl_info where{}, here{};
    ASSERT_NE(dladdr(bound, &where), 0) << name;
    ASSERT_NE(dladdr(reinterpret_cast<void*>(&keep_own_libm), &here), 0);
    EXPECT_EQ(where.dli_fbase, here.dli_fbase) << name << " comes from " << where.dli_fname;
  }
  dlclose(program);
}

TEST(LiftLibm, WhatBulletsHeadersCallHasTheBitsOfOurs) {
  for (int i = -2000; i <= 2000; ++i) {
    volatile double x = i * 0.0123;  // not folded by the compiler
    EXPECT_EQ(btSin(x), det::sin(x));
    EXPECT_EQ(btCos(x), det::cos(x));
    EXPECT_EQ(btAtan2(x, 1.0), det::atan2(x, 1.0));
  }
}

}  // namespace
}  // namespace evograsp::sim
