#include "grasp/candidates.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "grasp/jaw_hold.h"
#include "scenes/check.h"
#include "scenes/object_catalog.h"
#include "scenes/settings.h"

namespace pickbed {
namespace {

// Raised whenever the candidates of the same inputs would come out differently.
constexpr const char* kVersion = "pickbed grasps 4\n";
constexpr size_t kNumbersEach = 17;  // rows of [R|p], width, depth, quality, epsilon, robust
using PoseRows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

uint64_t Key(const ObjectModel& model, GripperSpec gripper, GraspCandidateOptions options) {
  std::string text = kVersion;
  text += fmt::format("{:016x} {} {} {} {} {} {}\n", model.mesh_hash, model.friction,
                      model.diameter_m, model.mass.mass_kg, model.mass.com_O.x(),
                      model.mass.com_O.y(), model.mass.com_O.z());
  text += WriteSettings([&](SettingsVisitor& v) { gripper.Visit(v); });
  text += WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  return HashBytes(text.data(), text.size());
}

std::string ToBytes(const std::vector<GraspCandidate>& candidates) {
  std::string bytes = kVersion;
  for (const GraspCandidate& candidate : candidates) {
    double numbers[kNumbersEach];
    Eigen::Map<PoseRows> rows(numbers);
    rows = candidate.X_OG.matrix().topRows<3>();
    numbers[12] = candidate.width_m;
    numbers[13] = candidate.depth_m;
    numbers[14] = candidate.quality;
    numbers[15] = candidate.epsilon;
    numbers[16] = candidate.robust;
    bytes.append(reinterpret_cast<const char*>(numbers), sizeof(numbers));
  }
  return bytes;
}

std::optional<std::vector<GraspCandidate>> FromBytes(const std::string& bytes) {
  const std::string version = kVersion;
  const size_t each = kNumbersEach * sizeof(double);
  if (!bytes.starts_with(version) || (bytes.size() - version.size()) % each != 0) return {};
  std::vector<GraspCandidate> candidates((bytes.size() - version.size()) / each);
  for (size_t i = 0; i < candidates.size(); ++i) {
    double numbers[kNumbersEach];
    std::memcpy(numbers, bytes.data() + version.size() + i * each, each);
    candidates[i].X_OG.matrix().topRows<3>() = Eigen::Map<const PoseRows>(numbers);
    candidates[i].width_m = numbers[12];
    candidates[i].depth_m = numbers[13];
    candidates[i].quality = numbers[14];
    candidates[i].epsilon = numbers[15];
    candidates[i].robust = numbers[16];
  }
  return candidates;
}

std::vector<GraspCandidate> JawCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                          Rng& rng, const GraspCandidateOptions& options) {
  const AntipodalOptions& pairs = options.antipodal;
  auto candidates = AntipodalGrasps(model, gripper, rng, pairs);
  if (candidates.empty()) return candidates;
  const SurfacePoints surface =
      SpreadPoints(model.mesh_O, pairs.point_spacing_m, pairs.min_points, pairs.max_points, rng);
  JudgeJawGrasps(model, gripper, surface, options.robust, rng.Next(), candidates);
  return candidates;
}

std::vector<GraspCandidate> CupCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                          Rng& rng, const GraspCandidateOptions& options) {
  return SuctionGrasps(model, gripper, rng, options.suction, options.robust);
}

}  // namespace

void GraspCandidateOptions::Visit(SettingsVisitor& v) {
  v.Group(
      "antipodal", [this](SettingsVisitor& g) { antipodal.Visit(g); }, "pairs for jaws");
  v.Group(
      "suction", [this](SettingsVisitor& g) { suction.Visit(g); }, "places for cups");
  v.Group(
      "robust", [this](SettingsVisitor& g) { robust.Visit(g); }, "sampled errors");
}

std::span<const CandidateMaker> CandidateMakerTable() {
  static constexpr std::array<CandidateMaker, 2> kTable{{
      {"parallel_jaw", "antipodal pair that fits its stroke", JawCandidates},
      {"suction_cup", "place that closes its lip", CupCandidates},
  }};
  return kTable;
}

const CandidateMaker& CandidateMakerOf(const GripperSpec& gripper) {
  for (const CandidateMaker& row : CandidateMakerTable()) {
    if (gripper.mechanism == row.mechanism) return row;
  }
  throw InputError(fmt::format("gripper '{}': there is no maker of grasps for mechanism '{}'",
                               gripper.name, gripper.mechanism));
}

std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                           Rng& rng, const GraspCandidateOptions& options) {
  return CandidateMakerOf(gripper).make(model, gripper, rng, options);
}

std::vector<GraspCandidate> CachedCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                             const GraspCandidateOptions& options) {
  const uint64_t key = Key(model, gripper, options);
  const std::filesystem::path file = CacheDir() / "grasps" / fmt::format("{:016x}", key);
  if (std::ifstream in(file, std::ios::binary); in) {
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    if (auto candidates = FromBytes(bytes)) return *std::move(candidates);
  }
  // Seeded by the key, so that a lost cache comes back the same.
  Rng rng(key);
  auto candidates = MakeCandidates(model, gripper, rng, options);
  std::filesystem::create_directories(file.parent_path());
  WriteFileAtomically(file, ToBytes(candidates));
  return candidates;
}

}  // namespace pickbed
