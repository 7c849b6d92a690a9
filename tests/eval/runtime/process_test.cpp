#include "eval/runtime/process.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/layer.h"

extern "C" {
int openblas_get_num_threads() __attribute__((weak));
int omp_get_max_threads() __attribute__((weak));
}

namespace pickbed::tests {
namespace {

TEST(Threads, EveryLibraryUsesOneThread) {
  UseOneThread();
  EXPECT_STREQ(getenv("OMP_NUM_THREADS"), "1");
  EXPECT_STREQ(getenv("OPENBLAS_NUM_THREADS"), "1");
  EXPECT_STREQ(getenv("LP_NUM_THREADS"), "0");
  ASSERT_NE(omp_get_max_threads, nullptr) << "libtorch brings OpenMP";
  EXPECT_EQ(omp_get_max_threads(), 1);
  if (openblas_get_num_threads == nullptr) GTEST_SKIP() << "the installed BLAS is not OpenBLAS";
  EXPECT_EQ(openblas_get_num_threads(), 1);
}

}  // namespace
}  // namespace pickbed::tests
