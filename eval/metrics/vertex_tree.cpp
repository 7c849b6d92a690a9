#include "eval/metrics/vertex_tree.h"

#include <cmath>
#include <flann/flann.hpp>

namespace pickbed::eval {
namespace {

constexpr int kLeafSize = 10;

}  // namespace

struct VertexTree::Impl {
  explicit Impl(const std::vector<Eigen::Vector3d>& all)
      : points(all),
        index(flann::Matrix<double>(points.front().data(), points.size(), 3),
              flann::KDTreeSingleIndexParams(kLeafSize)) {
    index.buildIndex();
  }

  std::vector<Eigen::Vector3d> points;  // FLANN refers to them
  flann::KDTreeSingleIndex<flann::L2_Simple<double>> index;
};

VertexTree::VertexTree(const std::vector<Eigen::Vector3d>& points)
    : impl_(std::make_shared<Impl>(points)) {}

std::vector<double> VertexTree::NearestDistances_m(
    const std::vector<Eigen::Vector3d>& queries) const {
  std::vector<double> distances_m(queries.size());
  if (queries.empty()) return distances_m;
  std::vector<size_t> rows(queries.size());
  // FLANN's interface takes values that are not const, and does not change them.
  const flann::Matrix<double> wanted(const_cast<double*>(queries.front().data()), queries.size(),
                                     3);
  flann::Matrix<size_t> nearest(rows.data(), rows.size(), 1);
  flann::Matrix<double> squared(distances_m.data(), distances_m.size(), 1);
  flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED);
  exact.cores = 1;
  impl_->index.knnSearch(wanted, nearest, squared, 1, exact);
  for (double& distance_m : distances_m) distance_m = std::sqrt(distance_m);
  return distances_m;
}

}  // namespace pickbed::eval
