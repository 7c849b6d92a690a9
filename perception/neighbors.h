#pragma once

// Nearest neighbours among descriptors: FLANN's tree of k-means clusters (Muja and Lowe 2014),
// which gives nearly all true neighbours at a small part of the cost of comparing with every row.
// Of 40,000 learned descriptors its randomised kd-trees found half as many true neighbours in four
// times the time.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "scenes/settings.h"

namespace pickbed {

struct NeighborOptions {
  int branching = 48;     // clusters that a node is divided into
  int iterations = 2;     // of k-means at a node; more = better recall and slower building
  int checks = 256;       // rows looked at for one query, or few more
  int linear_below = 64;  // sets with fewer rows are searched through exactly
  void Visit(SettingsVisitor& v);
};

struct Neighbors {
  int k = 0;
  std::vector<int> rows;       // queries x k, nearest first; -1 where the set has fewer rows
  std::vector<float> squared;  // squared Euclidean distances, in the same order
};

// The same rows and options give the same answers.
class NeighborIndex {
 public:
  // `rows` holds count x dimensions values, row after row; it is kept.
  NeighborIndex(std::vector<float> rows, int dimensions, const NeighborOptions& options = {});
  ~NeighborIndex();
  NeighborIndex(NeighborIndex&&) noexcept;
  NeighborIndex& operator=(NeighborIndex&&) noexcept;

  int size() const;
  Neighbors Search(std::span<const float> queries, int k, int threads = 1) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Exact, by comparing with every row; the reference of the tests.
Neighbors SearchExactly(std::span<const float> rows, std::span<const float> queries, int dimensions,
                        int k);

}  // namespace pickbed
