#include "perception/voting/vote_density.h"

#include <cmath>

namespace pickbed::perception {
namespace {

constexpr double kRounding = 1.001;  // margin for single precision

}  // namespace

VoteDensity::VoteDensity(const PoseEmbedding& embedding, const Eigen::Vector3d& com_O,
                         double diameter_m, double radius, const std::vector<PoseVote>& votes)
    : embedding_(embedding),
      com_O_(com_O),
      radius_(static_cast<float>(radius)),
      reach_m_(static_cast<float>(kRounding * embedding.Leverage(com_O) * radius * diameter_m)) {
  for (const PoseVote& vote : votes) {
    const Eigen::Vector3f com_C = (vote.X_CO * com_O_).cast<float>();
    const Eigen::Array3i at = Index(com_C);
    cells_[CellOf(at.x(), at.y(), at.z())].push_back(
        {com_C, embedding.Embed(vote.X_CO), vote.patch});
  }
}

Eigen::Array3i VoteDensity::Index(const Eigen::Vector3f& com_C) const {
  return (com_C / reach_m_).array().floor().cast<int>();
}

// Packs the indices with 21 bits per axis.
VoteDensity::Cell VoteDensity::CellOf(int x, int y, int z) const {
  constexpr int64_t kMask = (int64_t{1} << 21) - 1;
  return ((x & kMask) << 42) | ((y & kMask) << 21) | (z & kMask);
}

double VoteDensity::Around(const Pose& X_CO, int except_patch, Scratch& variants) const {
  const Eigen::Vector3f com_C = (X_CO * com_O_).cast<float>();
  embedding_.EmbedVariants(X_CO, variants);
  const Eigen::Array3i at = Index(com_C);
  const float reach2 = reach_m_ * reach_m_;
  const float radius2 = radius_ * radius_;
  double sum = 0;
  for (int i = 0; i < 27; ++i) {
    const auto cell =
        cells_.find(CellOf(at.x() + i % 3 - 1, at.y() + i / 3 % 3 - 1, at.z() + i / 9 - 1));
    if (cell == cells_.end()) continue;
    for (const Vote& vote : cell->second) {
      if (vote.patch == except_patch || (vote.com_C - com_C).squaredNorm() > reach2) continue;
      float nearest2 = radius2;
      for (Eigen::Index t = 0; t < variants.cols(); ++t) {
        // Most votes have a different rotation, which the first key points already show.
        float squared = (variants.col(t).head<8>() - vote.point.head<8>()).squaredNorm();
        if (squared >= nearest2) continue;
        squared += (variants.col(t).tail<16>() - vote.point.tail<16>()).squaredNorm();
        nearest2 = std::min(nearest2, squared);
      }
      sum += 1 - nearest2 / radius2;
    }
  }
  return sum;
}

}  // namespace pickbed::perception
