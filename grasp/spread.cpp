#include "grasp/spread.h"

#include <algorithm>
#include <array>

namespace pickbed {
namespace {

// Approach directions sorted into 3 x 3 cells on each face of a cube.
constexpr int kDirectionCells = 54;
int DirectionCell(const Eigen::Vector3d& direction) {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  const double scale = 1 / std::abs(direction[axis]);
  const auto third = [](double value) { return std::clamp(int((value + 1) * 1.5), 0, 2); };
  const int cell =
      3 * third(direction[(axis + 1) % 3] * scale) + third(direction[(axis + 2) % 3] * scale);
  return 9 * (2 * axis + (direction[axis] > 0 ? 1 : 0)) + cell;
}

}  // namespace

std::vector<GraspCandidate> SpreadOverDirections(
    std::vector<GraspCandidate> all, int wanted,
    const std::function<bool(const GraspCandidate&, const GraspCandidate&)>& same) {
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.quality > b.quality; });
  std::array<std::vector<const GraspCandidate*>, kDirectionCells> cells;
  for (const GraspCandidate& candidate : all) {
    cells[DirectionCell(candidate.X_OG.linear().col(2))].push_back(&candidate);
  }
  std::array<size_t, kDirectionCells> next{};
  std::vector<GraspCandidate> chosen;
  const auto take_one = [&](int cell) {
    while (next[cell] < cells[cell].size()) {
      const GraspCandidate& candidate = *cells[cell][next[cell]++];
      const bool known = std::any_of(chosen.begin(), chosen.end(),
                                     [&](const auto& other) { return same(candidate, other); });
      if (known) continue;
      chosen.push_back(candidate);
      return true;
    }
    return false;
  };
  for (bool progress = true; progress;) {
    progress = false;
    for (int cell = 0; cell < kDirectionCells; ++cell) {
      if (static_cast<int>(chosen.size()) >= wanted) return chosen;
      progress |= take_one(cell);
    }
  }
  return chosen;
}

}  // namespace pickbed
