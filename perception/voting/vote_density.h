#pragma once

// Density of votes around a pose. True poses collect votes from many patches; chance matches do
// not.

#include <Eigen/Core>
#include <unordered_map>
#include <vector>

#include "perception/model/pose_distance.h"

namespace pickbed::perception {

// A vote and the patch that cast it.
struct PoseVote {
  Pose X_CO = Pose::Identity();
  int patch = 0;  // kNoPatch: several patches
};
inline constexpr int kNoPatch = -1;

// Kernel density of the votes for one object, searched by cells of the center of mass.
class VoteDensity {
 public:
  // `radius` is the kernel radius: a root mean square displacement in diameters, see PoseEmbedding.
  // com_O is the center of mass of the object, which no symmetry moves. `embedding` must outlive
  // this object.
  VoteDensity(const PoseEmbedding& embedding, const Eigen::Vector3d& com_O, double diameter_m,
              double radius, const std::vector<PoseVote>& votes);

  // Returns the sum of 1 - (distance / radius)^2 over the votes within the radius of X_CO, without
  // the votes of `except_patch`. Each thread needs its own scratch. Does not allocate after the
  // first use of a scratch.
  using Scratch = PoseEmbedding::Points;
  double Around(const Pose& X_CO, int except_patch, Scratch& scratch) const;

 private:
  struct Vote {
    Eigen::Vector3f com_C;
    PoseEmbedding::Point point;
    int patch;
  };
  using Cell = int64_t;
  Cell CellOf(int x, int y, int z) const;
  Eigen::Array3i Index(const Eigen::Vector3f& com_C) const;

  const PoseEmbedding& embedding_;
  Eigen::Vector3d com_O_;
  float radius_ = 0;
  float reach_m_ = 0;  // maximum distance of the centers of mass of two poses within the radius
  std::unordered_map<Cell, std::vector<Vote>> cells_;  // cubes of side reach_m_
};

}  // namespace pickbed::perception
