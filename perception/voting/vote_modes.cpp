#include "perception/voting/vote_modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "scenes/base/error.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::perception {
namespace {

// Samples of a continuous symmetry. The mean is exact for any step, because it does not depend on
// the rotation about the axis.
constexpr int kSymmetrySteps = 24;
// A mean shift with a flat kernel converges in few steps.
constexpr int kShifts = 8;
// Votes at which the search for one rotation mode starts.
constexpr int kStartsForEach = 4;

struct Vote {
  Eigen::Vector3d center_C;
  Eigen::Quaterniond R_CO;
  double weight = 0;
};

using Cell = std::array<int, 3>;
using Cells = std::map<Cell, std::vector<int>>;  // votes by cell

template <typename Visit>
void ForNeighbours(const Cells& cells, const Cell& cell, const Visit& visit) {
  for (int n = 0; n < 27; ++n) {
    const Cell near{cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1};
    if (const auto found = cells.find(near); found != cells.end()) visit(*found);
  }
}

Cells CellsOf(const std::vector<Vote>& votes, double side_m) {
  constexpr double kLargest = 1e9;  // farther votes share the outermost cells
  Cells cells;
  for (size_t i = 0; i < votes.size(); ++i) {
    const Eigen::Array3i at =
        (votes[i].center_C / side_m).array().floor().max(-kLargest).min(kLargest).cast<int>();
    cells[{at[0], at[1], at[2]}].push_back(static_cast<int>(i));
  }
  return cells;
}

// Returns the cells whose weight, summed over the cell and its neighbours, is a local maximum.
std::vector<Cell> LocalMaxima(const Cells& cells, const std::vector<Vote>& votes,
                              double min_weight) {
  std::map<Cell, double> smooth;
  for (const auto& [cell, members] : cells) {
    double& sum = smooth[cell];
    ForNeighbours(cells, cell, [&](const auto& near) {
      for (const int i : near.second) sum += votes[i].weight;
    });
  }
  std::vector<Cell> maxima;
  for (const auto& [cell, weight] : smooth) {
    bool best = weight >= min_weight;
    ForNeighbours(cells, cell, [&](const auto& near) {
      const double other = smooth.at(near.first);
      best = best && (other < weight || (other == weight && cell <= near.first));
    });
    if (best) maxima.push_back(cell);
  }
  return maxima;
}

Eigen::Vector3d MeanCenter(const std::vector<Vote>& votes, const std::vector<int>& members) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 0;
  for (const int i : members) {
    sum += votes[i].weight * votes[i].center_C;
    weight += votes[i].weight;
  }
  return sum / weight;
}

// Mean shift from a cell. Returns the votes inside the kernel at its final position.
std::vector<int> ShiftCenter(const Cells& cells, const Cell& cell, const std::vector<Vote>& votes,
                             double radius_m) {
  std::vector<int> around;
  ForNeighbours(cells, cell, [&](const auto& near) {
    around.insert(around.end(), near.second.begin(), near.second.end());
  });
  std::vector<int> members = cells.at(cell);
  for (int shift = 0; shift < kShifts; ++shift) {
    const Eigen::Vector3d center_C = MeanCenter(votes, members);
    std::vector<int> inside;
    for (const int i : around) {
      if ((votes[i].center_C - center_C).norm() <= radius_m) inside.push_back(i);
    }
    if (inside.empty() || inside == members) break;
    members = std::move(inside);
  }
  return members;
}

struct RotationMode {
  std::vector<int> members;
  Eigen::Quaterniond mean;
  double weight = 0;
};

RotationMode Within(const ObjectRotations& rotations, const std::vector<Vote>& votes,
                    const std::vector<int>& among, const Eigen::Quaterniond& centre,
                    double radius_rad) {
  RotationMode mode{{}, centre, 0};
  std::vector<Eigen::Quaterniond> aligned;
  std::vector<double> weights;
  for (const int i : among) {
    const Eigen::Quaterniond near = rotations.Nearest(votes[i].R_CO, centre);
    if (near.angularDistance(centre) > radius_rad) continue;
    mode.members.push_back(i);
    aligned.push_back(near);
    weights.push_back(votes[i].weight);
    mode.weight += votes[i].weight;
  }
  if (!aligned.empty()) mode.mean = MeanRotation(aligned, weights);
  return mode;
}

// Returns the heaviest rotation mode among the votes, searched from several start votes.
RotationMode HeaviestRotation(const ObjectRotations& rotations, const std::vector<Vote>& votes,
                              const std::vector<int>& among, double radius_rad) {
  RotationMode best;
  const size_t starts = std::min<size_t>(kStartsForEach, among.size());
  for (size_t start = 0; start < starts; ++start) {
    // The starts are spread over the votes, which are sorted by weight.
    const int from = among[start * among.size() / starts];
    RotationMode mode = Within(rotations, votes, among, votes[from].R_CO, radius_rad);
    for (int shift = 0; shift < kShifts; ++shift) {
      RotationMode next = Within(rotations, votes, among, mode.mean, radius_rad);
      const bool rests = next.members == mode.members;
      if (next.weight < mode.weight) break;
      mode = std::move(next);
      if (rests) break;
    }
    if (mode.weight > best.weight) best = std::move(mode);
  }
  return best;
}

}  // namespace

void ModeOptions::Visit(SettingsVisitor& v) {
  v.Real("max_distance", max_distance, {1e-3, 10}, "maximum descriptor distance of a vote");
  v.Real("cell_diameters", cell_diameters, {1e-3, 1},
         "side of a cell of object centers, diameters");
  v.RenamedKey("middle_diameters", "center_diameters");
  v.Real("center_diameters", center_diameters, {1e-3, 1},
         "kernel radius of object centers, diameters");
  v.Real("rotation_rad", rotation_rad, {1e-3, 3.14}, "kernel radius of rotations, rad");
  v.Real("min_weight", min_weight, {0, 1e6}, "minimum total weight of the votes of a mode");
  v.Integer("rotations", rotations, {1, 1000},
            "maximum number of rotation modes at one object center");
}

ObjectRotations::ObjectRotations(const SymmetrySet& symmetries) {
  for (const Pose& S_O : SymmetryTransforms(symmetries, kSymmetrySteps)) {
    symmetries_O_.emplace_back(S_O.linear());
  }
}

Eigen::Quaterniond ObjectRotations::Nearest(const Eigen::Quaterniond& q,
                                            const Eigen::Quaterniond& reference) const {
  const Eigen::Quaterniond turn = q.conjugate() * reference;
  size_t best = 0;
  double largest = -1;
  for (size_t i = 0; i < symmetries_O_.size(); ++i) {
    const double cosine = std::abs(turn.dot(symmetries_O_[i]));
    if (cosine <= largest) continue;
    largest = cosine;
    best = i;
  }
  Eigen::Quaterniond nearest = q * symmetries_O_[best];
  if (nearest.dot(reference) < 0) nearest.coeffs() *= -1;
  return nearest;
}

double ObjectRotations::Angle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) const {
  return Nearest(a, b).angularDistance(b);
}

Eigen::Quaterniond MeanRotation(std::span<const Eigen::Quaterniond> rotations,
                                std::span<const double> weights) {
  if (rotations.empty()) throw std::logic_error("no rotations to average");
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (size_t i = 0; i < rotations.size(); ++i) {
    sum += weights[i] * rotations[i].coeffs() * rotations[i].coeffs().transpose();
  }
  return Eigen::Quaterniond(Eigen::Vector4d(EigenOfSymmetric(sum).vectors.col(3)));
}

std::vector<VoteMode> FindVoteModes(const ObjectModel& model, const ObjectRotations& rotations,
                                    const std::vector<CastVote>& cast, const ModeOptions& options) {
  CheckInput(model.diameter_m > 0,
             "object '" + model.name + "' has no diameter; give it the one of its mesh");
  const Eigen::Vector3d com_O = model.mass.com_O;
  std::vector<Vote> votes;
  for (const CastVote& vote : cast) {
    if (!(vote.distance <= options.max_distance)) continue;  // also if it is not a number
    votes.push_back({vote.X_CO * com_O, Eigen::Quaterniond(vote.X_CO.linear()),
                     std::exp(-static_cast<double>(vote.distance))});
  }
  std::stable_sort(votes.begin(), votes.end(),
                   [](const Vote& a, const Vote& b) { return a.weight > b.weight; });
  const Cells cells = CellsOf(votes, options.cell_diameters * model.diameter_m);
  std::vector<VoteMode> modes;
  for (const Cell& cell : LocalMaxima(cells, votes, options.min_weight)) {
    std::vector<int> left =
        ShiftCenter(cells, cell, votes, options.center_diameters * model.diameter_m);
    std::sort(left.begin(), left.end());  // by weight
    for (int n = 0; n < options.rotations && !left.empty(); ++n) {
      const RotationMode mode = HeaviestRotation(rotations, votes, left, options.rotation_rad);
      if (mode.weight < options.min_weight) break;
      const Eigen::Matrix3d R_CO = mode.mean.toRotationMatrix();
      modes.push_back({MakePose(R_CO, MeanCenter(votes, mode.members) - R_CO * com_O), mode.weight,
                       static_cast<int>(mode.members.size())});
      std::erase_if(left, [&](int i) {
        return std::binary_search(mode.members.begin(), mode.members.end(), i);
      });
    }
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const VoteMode& a, const VoteMode& b) { return a.weight > b.weight; });
  return modes;
}

}  // namespace pickbed::perception
