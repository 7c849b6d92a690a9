#include "grasp/candidates/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "scenes/base/cache_file.h"
#include "scenes/base/settings.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::grasp {
namespace {

// Must change whenever equal inputs give different candidates.
constexpr const char* kVersion = "pickbed grasps 5\n";
constexpr size_t kNumbersEach = 18;  // rows of [R|p], width, depth, the qualities
using PoseRows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

// Shortest text that reads back as the same numbers.
std::string Numbers(const Eigen::MatrixXd& values) {
  std::string text;
  for (const double value : values.reshaped()) text += fmt::format("{} ", value);
  return text;
}

uint64_t Key(const ObjectModel& model, const Gripper& gripper, GraspCandidateOptions options) {
  std::string text = kVersion;
  text += fmt::format("{:016x} {} {} {} {} {} {}\n", model.mesh_hash, model.friction,
                      model.diameter_m, model.mass.mass_kg, model.mass.com_O.x(),
                      model.mass.com_O.y(), model.mass.com_O.z());
  for (const RestingDirection& resting : model.resting_O) {
    text += fmt::format("rests {} {}\n", Numbers(resting.up_O), resting.probability);
  }
  for (const Pose& discrete : model.symmetries_O.discrete_O) {
    text += fmt::format("symmetry {}\n", Numbers(discrete.matrix()));
  }
  for (const ContinuousSymmetry& axis : model.symmetries_O.continuous_O) {
    text += fmt::format("axis {} {}\n", Numbers(axis.axis_O), Numbers(axis.offset_O));
  }
  for (const ConvexPiece& piece : model.convex_pieces_O) {
    text += "piece";
    for (const Eigen::Vector3d& vertex : piece.vertices_O) text += ' ' + Numbers(vertex);
    text += '\n';
  }
  text += gripper.SettingsText();
  text += WriteSettingsKey([&](SettingsVisitor& v) { options.Visit(v); });
  return HashBytes(text.data(), text.size());
}

std::string ToBytes(const std::vector<GraspCandidate>& candidates) {
  std::string bytes;
  for (const GraspCandidate& candidate : candidates) {
    double numbers[kNumbersEach];
    Eigen::Map<PoseRows> rows(numbers);
    rows = candidate.X_OG.matrix().topRows<3>();
    numbers[12] = candidate.width_m;
    numbers[13] = candidate.depth_m;
    numbers[14] = candidate.quality;
    numbers[15] = candidate.epsilon;
    numbers[16] = candidate.robust;
    numbers[17] = candidate.place_quality;
    bytes.append(reinterpret_cast<const char*>(numbers), sizeof(numbers));
  }
  return bytes;
}

std::vector<GraspCandidate> FromBytes(const std::string& bytes) {
  const size_t each = kNumbersEach * sizeof(double);
  CheckInput(bytes.size() % each == 0, "a candidate is cut short");
  std::vector<GraspCandidate> candidates(bytes.size() / each);
  for (size_t i = 0; i < candidates.size(); ++i) {
    double numbers[kNumbersEach];
    std::memcpy(numbers, bytes.data() + i * each, each);
    candidates[i].X_OG.matrix().topRows<3>() = Eigen::Map<const PoseRows>(numbers);
    candidates[i].width_m = numbers[12];
    candidates[i].depth_m = numbers[13];
    candidates[i].quality = numbers[14];
    candidates[i].epsilon = numbers[15];
    candidates[i].robust = numbers[16];
    candidates[i].place_quality = numbers[17];
  }
  return candidates;
}

}  // namespace

void GraspCandidateOptions::Visit(SettingsVisitor& v) {
  v.Group(
      "antipodal", [this](SettingsVisitor& g) { antipodal.Visit(g); },
      "antipodal candidates for jaws");
  v.Group(
      "suction", [this](SettingsVisitor& g) { suction.Visit(g); }, "suction candidates for cups");
  v.Group(
      "robust", [this](SettingsVisitor& g) { robust.Visit(g); }, "robustness under sampled errors");
  v.Group(
      "place", [this](SettingsVisitor& g) { place.Visit(g); }, "placement of a picked object");
}

std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, const Gripper& gripper,
                                           Rng& rng, const GraspCandidateOptions& options) {
  gripper.Check();
  CheckSettings("GraspCandidateOptions", options);
  auto candidates = gripper.MakeCandidates(model, rng, options);
  std::vector<Pose> X_OG;
  std::vector<std::vector<AxisAlignedBox>> boxes;
  for (const GraspCandidate& candidate : candidates) {
    X_OG.push_back(candidate.X_OG);
    const auto opening_m = gripper.ApproachOpening_m(candidate.width_m);
    boxes.push_back(gripper.Boxes(opening_m.value_or(gripper.MaxOpening_m())));
  }
  const std::vector<double> worths = SetDownWorths(model, X_OG, boxes, options.place);
  for (size_t i = 0; i < candidates.size(); ++i) candidates[i].place_quality = worths[i];
  return candidates;
}

std::vector<GraspCandidate> CachedCandidates(const ObjectModel& model, const Gripper& gripper,
                                             const GraspCandidateOptions& options) {
  gripper.Check();
  CheckSettings("GraspCandidateOptions", options);
  const uint64_t key = Key(model, gripper, options);
  const std::filesystem::path file = CacheDir() / "grasps" / fmt::format("{:016x}.grasps", key);
  const auto make = [&] {
    Rng rng(key);  // the same candidates after the cache was deleted
    return MakeCandidates(model, gripper, rng, options);
  };
  return Cached(file, FromBytes, make, ToBytes);
}

namespace {

// Bins approach directions into 3 x 3 cells on each face of a cube.
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

}  // namespace pickbed::grasp
