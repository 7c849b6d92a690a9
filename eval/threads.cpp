#include "eval/threads.h"

#include <stdlib.h>

#include <initializer_list>

// Weak: there when the process has OpenBLAS or OpenMP, null when another BLAS is installed.
extern "C" {
void openblas_set_num_threads(int threads) __attribute__((weak));
void omp_set_num_threads(int threads) __attribute__((weak));
}

namespace pickbed {

void UseOneThread() {
  for (const char* name :
       {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"}) {
    setenv(name, "1", 1);
  }
  // llvmpipe draws fastest without raster threads when every worker has its own context.
  setenv("LP_NUM_THREADS", "0", 1);
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  if (omp_set_num_threads != nullptr) omp_set_num_threads(1);
}

}  // namespace pickbed
