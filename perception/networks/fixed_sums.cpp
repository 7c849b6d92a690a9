#include "perception/networks/fixed_sums.h"

namespace pickbed::perception {
namespace {

// Half a row. The compiler splits it into two registers where there are none of this size.
typedef float Lanes __attribute__((vector_size(kSumLanes * sizeof(float)), aligned(4), may_alias));

}  // namespace

// Several columns are computed at once, which does not change the order within a column. The
// variant for AVX2 has no fused multiply-add, so that both variants round alike.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
__attribute__((target_clones("avx2", "default")))
#endif
void AddProducts(const SumBlock& block, float* sums) {
  static_assert(kSumRows == 4 && kSumColumns == 2 * kSumLanes);
  const float *const row_a = block.rows, *const row_b = row_a + block.terms;
  const float *const row_c = row_b + block.terms, *const row_d = row_c + block.terms;
  const float *const block_left = block.left, *const block_right = block.right;
  Lanes *const stored = reinterpret_cast<Lanes *>(sums);
  Lanes a0 = stored[0], a1 = stored[1], b0 = stored[2], b1 = stored[3];
  Lanes c0 = stored[4], c1 = stored[5], d0 = stored[6], d1 = stored[7];
  for (int64_t k = 0; k < block.terms; ++k) {
    const int64_t offset = block.offsets[k];
    const Lanes left = *reinterpret_cast<const Lanes *>(block_left + offset);
    const Lanes right = *reinterpret_cast<const Lanes *>(block_right + offset);
    const float a = row_a[k], b = row_b[k], c = row_c[k], d = row_d[k];
    a0 += a * left;
    a1 += a * right;
    b0 += b * left;
    b1 += b * right;
    c0 += c * left;
    c1 += c * right;
    d0 += d * left;
    d1 += d * right;
  }
  stored[0] = a0, stored[1] = a1, stored[2] = b0, stored[3] = b1;
  stored[4] = c0, stored[5] = c1, stored[6] = d0, stored[7] = d1;
}

}  // namespace pickbed::perception
