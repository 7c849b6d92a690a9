#include "eval/threads.h"

#include <dlfcn.h>
#include <stdlib.h>

#include <initializer_list>

namespace pickbed {

void UseOneThread() {
  for (const char* name : {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS",
                           "OPENCV_FOR_THREADS_NUM", "LP_NUM_THREADS"}) {
    // llvmpipe draws fastest without raster threads when every worker has its own context.
    const bool is_llvmpipe = name[0] == 'L';
    setenv(name, is_llvmpipe ? "0" : "1", 1);
  }
  for (const char* name : {"openblas_set_num_threads", "omp_set_num_threads"}) {
    if (void* entry = dlsym(RTLD_DEFAULT, name)) reinterpret_cast<void (*)(int)>(entry)(1);
  }
}

}  // namespace pickbed
