#pragma once

// How loops over pixels are compiled. Private to .cpp files.
//
// There are versions of the same arithmetic for processors with wider vectors; CMakeLists.txt
// has the compiler round products and sums one by one, so that their results are the same.

#define PICKBED_WIDTHS __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#define PICKBED_INLINE inline __attribute__((always_inline))  // a clone calls nothing narrower

namespace pickbed {

// Four floats of an array, for which every x86-64 has instructions.
using Four = float __attribute__((vector_size(16), aligned(4), may_alias));

}  // namespace pickbed
