#include "perception/features/neighbors.h"

#include <algorithm>
#include <flann/flann.hpp>
#include <optional>
#include <utility>

#include "scenes/base/error.h"
#include "scenes/base/parallel.h"
#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

// A separate type, for which the specialization below replaces one step of FLANN's tree building.
// FLANN takes the order of that step from std::random_device, which is not reproducible.
struct RepeatableL2 : flann::L2<float> {};

}  // namespace
}  // namespace pickbed::perception

namespace flann {

// Same contract as FLANN's: draws k distinct rows at random, or fewer if there are not enough.
template <>
void RandomCenterChooser<pickbed::perception::RepeatableL2>::operator()(int k, int* indices,
                                                                        int indices_length,
                                                                        int* centers,
                                                                        int& centers_length) {
  constexpr float kSame = 1e-16f;  // squared distance below which two rows count as equal
  pickbed::scenes::Rng rng(indices_length);
  std::vector<int> order(indices, indices + indices_length);
  centers_length = 0;
  for (int i = 0; i < indices_length && centers_length < k; ++i) {
    std::swap(order[i], order[i + rng.Index(indices_length - i)]);
    const bool is_new = std::none_of(centers, centers + centers_length, [&](int center) {
      return distance_(points_[order[i]], points_[center], cols_) < kSame;
    });
    if (is_new) centers[centers_length++] = order[i];
  }
}

}  // namespace flann

namespace pickbed::perception {

void NeighborOptions::Visit(SettingsVisitor& v) {
  v.Integer("branching", branching, {2, 1000}, "number of clusters per node of the index");
  v.Integer("iterations", iterations, {0, 1000}, "number of k-means iterations per node");
  v.Integer("checks", checks, {1, 100000}, "number of rows compared per query");
  v.Integer("linear_below", linear_below, {0, kAlwaysLinear},
            "sets with fewer rows than this are searched exactly");
}

struct NeighborIndex::Impl {
  std::vector<float> rows;
  int dimensions = 0;
  int count = 0;
  NeighborOptions options;
  std::optional<flann::KMeansIndex<RepeatableL2>> tree;
};

NeighborIndex::NeighborIndex(std::vector<float> rows, int dimensions,
                             const NeighborOptions& options)
    : impl_(std::make_unique<Impl>()) {
  CheckSettings("NeighborOptions", options);
  CheckInput(dimensions > 0 && rows.size() % dimensions == 0,
             "a neighbor index needs complete rows of descriptors");
  impl_->rows = std::move(rows);
  impl_->dimensions = dimensions;
  impl_->count = static_cast<int>(impl_->rows.size() / dimensions);
  impl_->options = options;
  if (impl_->count < std::max(options.linear_below, 2)) return;
  impl_->tree.emplace(
      flann::Matrix<float>(impl_->rows.data(), impl_->count, dimensions),
      flann::KMeansIndexParams(options.branching, options.iterations, flann::FLANN_CENTERS_RANDOM));
  impl_->tree->buildIndex();
}

NeighborIndex::~NeighborIndex() = default;
NeighborIndex::NeighborIndex(NeighborIndex&&) noexcept = default;
NeighborIndex& NeighborIndex::operator=(NeighborIndex&&) noexcept = default;

int NeighborIndex::size() const { return impl_->count; }

Neighbors NeighborIndex::Search(std::span<const float> queries, int k, int threads) const {
  if (!impl_->tree) return SearchExactly(impl_->rows, queries, impl_->dimensions, k);
  const size_t count = queries.size() / impl_->dimensions;
  Neighbors found{k, std::vector<int>(count * k, -1), std::vector<float>(count * k, 0)};
  if (count == 0) return found;
  const int reachable = std::min(k, impl_->count);
  flann::SearchParams params(impl_->options.checks);
  params.cores = 1;
  const size_t length = impl_->dimensions;
  ForRanges(static_cast<int>(count), threads, [&](int begin, int end) {
    const size_t size = end - begin;
    // FLANN's matrices are not const-correct; it only reads the queries.
    const flann::Matrix<float> query(const_cast<float*>(queries.data()) + begin * length, size,
                                     length);
    flann::Matrix<int> rows(found.rows.data() + static_cast<size_t>(begin) * k, size, k);
    flann::Matrix<float> squared(found.squared.data() + static_cast<size_t>(begin) * k, size, k);
    impl_->tree->knnSearch(query, rows, squared, reachable, params);
  });
  return found;
}

Neighbors SearchExactly(std::span<const float> rows, std::span<const float> queries, int dimensions,
                        int k) {
  const size_t count = queries.size() / dimensions;
  const size_t row_count = rows.size() / dimensions;
  const size_t reachable = std::min<size_t>(k, row_count);
  Neighbors found{k, std::vector<int>(count * k, -1), std::vector<float>(count * k, 0)};
  std::vector<float> squared(row_count);
  std::vector<int> order(row_count);
  for (size_t q = 0; q < count; ++q) {
    const float* query = queries.data() + q * dimensions;
    for (size_t r = 0; r < row_count; ++r) {
      const float* row = rows.data() + r * dimensions;
      float sum = 0;
      for (int d = 0; d < dimensions; ++d) sum += (query[d] - row[d]) * (query[d] - row[d]);
      squared[r] = sum;
    }
    std::iota(order.begin(), order.end(), 0);
    std::partial_sort(order.begin(), order.begin() + reachable, order.end(), [&](int a, int b) {
      return squared[a] != squared[b] ? squared[a] < squared[b] : a < b;
    });
    for (size_t i = 0; i < reachable; ++i) {
      found.rows[q * k + i] = order[i];
      found.squared[q * k + i] = squared[order[i]];
    }
  }
  return found;
}

}  // namespace pickbed::perception
