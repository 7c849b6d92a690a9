#include "perception/voting/vote_density.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace pickbed::perception {
namespace {

constexpr double kRounding = 1.001;  // margin for single precision

}  // namespace

VoteDensity::VoteDensity(const PoseEmbedding& embedding, const Eigen::Vector3d& com_O,
                         double diameter_m, double radius, const std::vector<PoseVote>& votes)
    : embedding_(embedding),
      com_O_(com_O),
      radius_(static_cast<float>(radius)),
      reach_m_(static_cast<float>(kRounding * embedding.Leverage(com_O) * radius * diameter_m)),
      blocks_((votes.size() + kLanes - 1) / kLanes) {
  std::vector<Eigen::Vector3f> coms_C;
  std::vector<Cell> cell_of_vote;
  for (const PoseVote& vote : votes) {
    coms_C.push_back((vote.X_CO * com_O_).cast<float>());
    const Eigen::Array3i at = Index(coms_C.back());
    cell_of_vote.push_back(CellOf(at.x(), at.y(), at.z()));
    ++cells_[cell_of_vote.back()].end;
  }
  // The votes of a cell are consecutive, and so are the cells along x.
  std::vector<Cell> order;
  for (const auto& [cell, count] : cells_) order.push_back(cell);
  std::sort(order.begin(), order.end());
  int begin = 0;
  for (const Cell cell : order) {
    Range& range = cells_[cell];
    const int next = begin + range.end;
    range = {begin, begin};
    begin = next;
  }
  for (size_t v = 0; v < votes.size(); ++v) {
    const int i = cells_[cell_of_vote[v]].end++;
    VoteBlock& block = blocks_[i / kLanes];
    const PoseEmbedding::Point point = embedding.Embed(votes[v].X_CO);
    for (int k = 0; k < 3; ++k) block.com_C[k][i % kLanes] = coms_C[v][k];
    for (int k = 0; k < point.size(); ++k) block.point[k][i % kLanes] = point[k];
    block.patch[i % kLanes] = votes[v].patch;
  }
}

// Far votes share the outermost cells; their distance separates them.
Eigen::Array3i VoteDensity::Index(const Eigen::Vector3f& com_C) const {
  constexpr float kLargest = (1 << 20) - 2;  // with its neighbours, see CellOf()
  return (com_C / reach_m_).array().floor().max(-kLargest).min(kLargest).cast<int>();
}

// Packs the indices with 21 bits per axis. The next cell along x has the next number.
VoteDensity::Cell VoteDensity::CellOf(int x, int y, int z) {
  constexpr int64_t kMask = (int64_t{1} << 21) - 1, kZero = int64_t{1} << 20;
  return (((z + kZero) & kMask) << 42) | (((y + kZero) & kMask) << 21) | ((x + kZero) & kMask);
}

// Adds the votes of a range to `sum`, one after another: the result does not depend on the width of
// the registers. Lanes outside the range, beyond the reach or of the excepted patch are inactive.
__attribute__((target_clones("avx2", "default"))) double VoteDensity::AddVotes(
    const VoteBlock* blocks, const Range& votes, const Query& query, double sum) {
  const auto any = [](const Ints& lanes) {
    int64_t words[kLanes / 2];
    std::memcpy(words, &lanes, sizeof(words));
    return (words[0] | words[1] | words[2] | words[3]) != 0;
  };
  const Eigen::Vector3f& com_C = query.com_C;
  const Ints lane = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int b = votes.begin / kLanes; b * kLanes < votes.end; ++b) {
    const VoteBlock& block = blocks[b];
    const Ints i = lane + b * kLanes;
    const Floats dx = block.com_C[0] - com_C.x(), dy = block.com_C[1] - com_C.y(),
                 dz = block.com_C[2] - com_C.z();
    const Ints active = (dx * dx + (dy * dy + dz * dz) <= query.reach2) & (i >= votes.begin) &
                        (i < votes.end) & (block.patch != query.except_patch);
    if (!any(active)) continue;
    // No distance is below the 0 of an inactive lane.
    Floats nearest2 =
        reinterpret_cast<Floats>(reinterpret_cast<Ints>(Floats{} + query.radius2) & active);
    for (Eigen::Index t = 0; t < query.variants.cols(); ++t) {
      const float* variant = query.variants.col(t).data();
      Floats squares[4];
      for (int k = 0; k < 4; ++k) {
        const Floats p = variant[k] - block.point[k], q = variant[k + 4] - block.point[k + 4];
        squares[k] = p * p + q * q;
      }
      Floats distance2 = (squares[0] + squares[2]) + (squares[1] + squares[3]);
      // Most votes have a different rotation, which the first key points already show.
      if (!any(distance2 < nearest2)) continue;
      for (int k = 0; k < 4; ++k) {
        const Floats p = variant[k + 8] - block.point[k + 8],
                     q = variant[k + 12] - block.point[k + 12],
                     r = variant[k + 16] - block.point[k + 16],
                     s = variant[k + 20] - block.point[k + 20];
        squares[k] = (p * p + q * q) + (r * r + s * s);
      }
      distance2 += (squares[0] + squares[2]) + (squares[1] + squares[3]);
      nearest2 = distance2 < nearest2 ? distance2 : nearest2;
    }
    const Floats term =
        reinterpret_cast<Floats>(reinterpret_cast<Ints>(1 - nearest2 / query.radius2) & active);
    for (int k = 0; k < kLanes; ++k) sum += term[k];
  }
  return sum;
}

double VoteDensity::Around(const Pose& X_CO, int except_patch, Scratch& variants) const {
  embedding_.EmbedVariants(X_CO, variants);
  const Query query{(X_CO * com_O_).cast<float>(), variants, reach_m_ * reach_m_, radius_ * radius_,
                    except_patch};
  const Eigen::Array3i at = Index(query.com_C);
  double sum = 0;
  Range votes;
  for (int i = 0; i < 27; ++i) {
    const auto cell =
        cells_.find(CellOf(at.x() + i % 3 - 1, at.y() + i / 3 % 3 - 1, at.z() + i / 9 - 1));
    if (cell == cells_.end()) continue;
    if (cell->second.begin == votes.end) {
      votes.end = cell->second.end;
      continue;
    }
    sum = AddVotes(blocks_.data(), votes, query, sum);
    votes = cell->second;
  }
  return AddVotes(blocks_.data(), votes, query, sum);
}

}  // namespace pickbed::perception
