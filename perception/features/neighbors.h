#pragma once

// Nearest-neighbour search among descriptors with FLANN's hierarchical k-means tree (Muja and Lowe
// 2014). It finds nearly all true neighbours at a small share of the cost of a linear search. On
// 40,000 learned descriptors, FLANN's randomised kd-trees found half as many true neighbours in
// four times the time.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "perception/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct NeighborOptions {
  int branching = 48;  // clusters per node
  int iterations = 2;  // k-means iterations per node; more = better recall, slower building
  int checks = 256;    // rows compared per query, approximately
  static constexpr int kAlwaysLinear = 1000000;
  int linear_below = 64;  // sets with fewer rows are searched exactly
  void Visit(SettingsVisitor& v);
};

// Result of a search: k neighbours per query.
struct Neighbors {
  int k = 0;
  std::vector<int> rows;       // queries x k, nearest first; -1 where the set has fewer rows
  std::vector<float> squared;  // squared Euclidean distances, in the same order
};

// Search index over a set of descriptors. Results depend only on the rows and the options.
class NeighborIndex {
 public:
  // Takes count x dimensions values, row by row. Throws InputError if the rows are not whole.
  NeighborIndex(std::vector<float> rows, int dimensions, const NeighborOptions& options = {});
  ~NeighborIndex();
  NeighborIndex(NeighborIndex&&) noexcept;
  NeighborIndex& operator=(NeighborIndex&&) noexcept;

  int size() const;
  // Returns the k nearest rows of each query; `queries` holds count x dimensions values.
  Neighbors Search(std::span<const float> queries, int k, int threads = 1) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Exact linear search over all rows; also the reference in tests. Equal distances are ordered by
// row.
Neighbors SearchExactly(std::span<const float> rows, std::span<const float> queries, int dimensions,
                        int k);

}  // namespace pickbed::perception
