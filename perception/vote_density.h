#pragma once

// How many votes stand near a pose: true poses gather votes from many patches, chance hits don't.

#include <Eigen/Core>
#include <unordered_map>
#include <vector>

#include "perception/pose_embedding.h"

namespace pickbed {

// A vote and the patch that cast it.
struct PoseVote {
  Pose X_CO = Pose::Identity();
  int patch = 0;  // kNoPatch: several together
};
inline constexpr int kNoPatch = -1;

class VoteDensity {
 public:
  // Votes within `radius` of a pose count, in diameters of root mean square displacement
  // (pose_embedding.h); com_O is the part's centre of mass, which no symmetry moves.
  VoteDensity(const PoseEmbedding& embedding, const Eigen::Vector3d& com_O, double diameter_m,
              double radius, const std::vector<PoseVote>& votes);

  // Sum of 1 - (distance / radius)^2 over the votes near X_CO, without those of `except_patch`. No
  // allocation after a scratch's first use; one for each thread.
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
  float reach_m_ = 0;  // centres of mass farther apart than this belong to poses beyond the radius
  std::unordered_map<Cell, std::vector<Vote>> cells_;  // cubes of side reach_m_
};

}  // namespace pickbed
