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
  // Votes are processed eight at a time. The compiler splits the vectors if the processor has
  // narrower registers.
  static constexpr int kLanes = 8;
  using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
  using Ints = int32_t __attribute__((vector_size(kLanes * sizeof(float))));

  // Eight votes, one per lane.
  struct alignas(kLanes * sizeof(float)) VoteBlock {
    Floats com_C[3];
    Floats point[PoseEmbedding::Point::RowsAtCompileTime];
    Ints patch;
  };
  // Votes begin .. end - 1. Vote i is in lane i % kLanes of block i / kLanes.
  struct Range {
    int begin = 0, end = 0;
  };
  // A pose and the limits within which votes count.
  struct Query {
    Eigen::Vector3f com_C;
    const Scratch& variants;
    float reach2, radius2;
    int except_patch;
  };
  using Cell = int64_t;
  static Cell CellOf(int x, int y, int z);
  Eigen::Array3i Index(const Eigen::Vector3f& com_C) const;
  static double AddVotes(const VoteBlock* blocks, const Range& votes, const Query& query,
                         double sum);

  const PoseEmbedding& embedding_;
  Eigen::Vector3d com_O_;
  float radius_ = 0;
  float reach_m_ = 0;  // maximum distance of the centers of mass of two poses within the radius
  std::vector<VoteBlock> blocks_;          // in the order of their cells
  std::unordered_map<Cell, Range> cells_;  // cubes of side reach_m_
};

}  // namespace pickbed::perception
