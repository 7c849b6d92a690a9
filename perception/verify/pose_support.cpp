#include "perception/verify/pose_support.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace pickbed::perception {
namespace {

// The compiler splits the columns if the processor has narrower registers.
using Column = float __attribute__((vector_size(8 * sizeof(float))));

// Sets `sum` to the first six columns of the sum of row * row^T. The variant for AVX2 has no fused
// multiply-add, so that both variants round alike.
__attribute__((target_clones("avx2", "default"))) void SumSquares(
    const std::vector<std::array<float, 8>>& rows, Eigen::Matrix<float, 8, 6>& sum) {
  Column columns[6] = {};
  for (const std::array<float, 8>& values : rows) {
    Column row;
    std::memcpy(&row, values.data(), sizeof(row));
    for (int i = 0; i < 6; ++i) columns[i] += values[i] * row;
  }
  for (int i = 0; i < 6; ++i) std::memcpy(sum.col(i).data(), &columns[i], sizeof(Column));
}

}  // namespace

void PoseSupportMeasure::Begin(const Eigen::Vector3f& center_C, float radius_m, float band_m) {
  center_C_ = center_C;
  radius_m_ = radius_m;
  band_m_ = band_m;
  covered_ = outline_ = outline_seen_ = 0;
  rows_.clear();
  agreeing_C_.clear();
  normals_C_.clear();
  others_C_.clear();
}

void PoseSupportMeasure::Hold(const Eigen::Vector3f& p_C, const Eigen::Vector3f& direction_C) {
  Eigen::Vector4f arm;
  arm << p_C - center_C_, 0;
  arm /= radius_m_;
  const Eigen::Vector3f turn = arm.head<3>().cross(direction_C);
  rows_.push_back(
      {direction_C.x(), direction_C.y(), direction_C.z(), turn.x(), turn.y(), turn.z(), 0, 0});
}

void PoseSupportMeasure::AddAgreeing(const Eigen::Vector3f& p_C, const Eigen::Vector3f& normal_C) {
  Hold(p_C, normal_C);
  agreeing_C_.push_back(p_C);
  normals_C_.push_back(normal_C);
}

void PoseSupportMeasure::AddOutline(const Eigen::Vector3f& p_C, const Eigen::Vector3f& across_C,
                                    bool seen) {
  ++outline_;
  if (!seen) return;
  ++outline_seen_;
  Hold(p_C, across_C);
}

// The plane is the one with the most agreeing readings of a few that are tried.
double PoseSupportMeasure::CoplanarShare() const {
  constexpr size_t kPlanes = 8, kReadings = 256;  // tried planes; readings compared with each
  constexpr float kMinCos = 0.97f;
  const size_t step = std::max<size_t>(1, agreeing_C_.size() / kPlanes);
  const size_t stride = std::max<size_t>(1, agreeing_C_.size() / kReadings);
  size_t best = 0, max_on_plane = 0;
  for (size_t i = step / 2; i < agreeing_C_.size(); i += step) {
    size_t on_plane = 0;
    for (size_t j = 0; j < agreeing_C_.size(); j += stride) {
      on_plane += std::abs(normals_C_[i].dot(agreeing_C_[j] - agreeing_C_[i])) < band_m_ &&
                  normals_C_[i].dot(normals_C_[j]) > kMinCos;
    }
    if (on_plane <= max_on_plane) continue;
    max_on_plane = on_plane;
    best = i;
  }
  const auto coplanar =
      std::count_if(others_C_.begin(), others_C_.end(), [&](const Eigen::Vector3f& p_C) {
        return std::abs(normals_C_[best].dot(p_C - agreeing_C_[best])) < band_m_;
      });
  const size_t compared = (agreeing_C_.size() + stride - 1) / stride;
  const double planar = static_cast<double>(max_on_plane) / static_cast<double>(compared);
  return std::min(kMaxCoplanar, planar * static_cast<double>(coplanar) / covered_);
}

PoseSupport PoseSupportMeasure::Finish() const {
  PoseSupport support;
  if (covered_ == 0 || agreeing_C_.empty()) return support;
  Eigen::Matrix<float, 8, 6> held;
  SumSquares(rows_, held);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<float, 6, 6>> eigen(held.topRows<6>(),
                                                                        Eigen::EigenvaluesOnly);
  const auto per_pixel = [&](float sum) { return std::sqrt(std::max(0.0f, sum) / covered_); };
  support.weakest = per_pixel(eigen.eigenvalues()[0]);
  support.second_weakest = per_pixel(eigen.eigenvalues()[1]);
  support.outline_seen = outline_ > 0 ? static_cast<double>(outline_seen_) / outline_ : 0;
  support.coplanar = CoplanarShare();
  return support;
}

}  // namespace pickbed::perception
