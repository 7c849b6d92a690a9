#include <array>

#include "grasp/plan.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr std::array<RankingRow, 4> kRankings{{
    {"quality", "angle, area, depth and lever of the contacts, 0..1",
     [](const GraspCandidate& candidate) { return candidate.quality; }},
    {"epsilon", "the least load that is too much, from any direction",
     [](const GraspCandidate& candidate) { return candidate.epsilon / (1 + candidate.epsilon); }},
    {"robust", "share of sampled errors that it survives",
     [](const GraspCandidate& candidate) { return candidate.robust; }},
    {"random", "chance alone among the grasps without collision: what ranking has to beat",
     nullptr},
}};

}  // namespace

void WiderLimits::Visit(SettingsVisitor& v) {
  v.Bool("look", look, "look again where nothing was found");
  v.Real("max_tilt_rad", max_tilt_rad, {0.01, 1.6}, "of the approach from straight down, rad");
  v.Real("min_quality", min_quality, {0, 1}, "worse candidates are left alone");
  v.Real("clearance_share", clearance_share, {-2, 1}, "of the gripper's clearance");
  v.Real("bin_clearance_m", bin_clearance_m, {0, 0.1}, "kept between hand and bin, m");
}

void PlanOptions::Visit(SettingsVisitor& v) {
  const Range share{0, 1};
  const Range length{0, 0.1};
  v.Integer("max_grasps", max_grasps, {1, 1000}, "reported");
  std::vector<std::string> rankings;
  for (const RankingRow& row : kRankings) rankings.push_back(row.name);
  v.Text("ranking", ranking, rankings, "by what of a candidate grasps are ranked");
  v.Seed("seed", seed, "of the ranking by chance");
  v.Real("max_tilt_rad", max_tilt_rad, {0.01, 1.6}, "of the approach from straight down, rad");
  v.Real("own_points_m", own_points_m, {0.001, 0.1}, "points this near are the target's own, m");
  v.Real("clearance_share", clearance_share, {-2, 1}, "of the gripper's clearance");
  v.Real("bin_clearance_m", bin_clearance_m, length, "kept between hand and bin, m");
  v.Real("min_depth_m", min_depth_m, length, "contact behind the tips, at least, m");
  v.Real("good_depth_m", good_depth_m, {0.001, 0.1}, "contact behind the tips without loss, m");
  v.Real("min_quality", min_quality, share, "worse candidates are left alone");
  v.Real("voxel_m", voxel_m, {0.0005, 0.1}, "the cloud is thinned to, m");
  v.Real("bin_band_m", bin_band_m, length, "points this near to floor and walls are the bin's, m");
  v.Real("neighbor_confidence", neighbor_confidence, {0, 1e9}, "poses from here on are obstacles");
  v.Real("neighbor_spacing_m", neighbor_spacing_m, {0.001, 0.1}, "of the points on them, m");
  v.Real("same_share", same_share, share, "of the diameter; nearer poses are rivals");
  v.Real("same_thickness_share", same_thickness_share, share,
         "of the least extent, within which rivals are too");
  v.Real("height_share", height_share, share, "lost by the lowest part");
  v.Real("tilt_share", tilt_share, share, "lost at max_tilt_rad");
  v.Real("room_share", room_share, share, "lost when others touch the hand");
  v.Real("cover_share", cover_share, share, "lost when others lie all over the target");
  v.Real("aside_share", aside_share, share, "lost by a hand that stands aside for a wall");
  v.Real("set_down_share", set_down_share, share, "lost when the part cannot be laid down so held");
  v.Real("between_share", between_share, share, "lost when others are between the fingers");
  v.Real("good_room_m", good_room_m, {0.001, 0.1}, "distance from others without loss, m");
  v.Integer("many_between", many_between, {1, 100000}, "points between fingers at full loss");
  v.Real("column_m", column_m, {0.001, 0.1}, "of the floor plan that sorts the points, m");
  v.Integer("min_part_points", min_part_points, {10, 100000}, "on a believed pose, at least");
  v.Integer("max_part_points", max_part_points, {10, 100000}, "on a believed pose, at most");
  v.Group(
      "wide", [this](SettingsVisitor& g) { wide.Visit(g); }, "where nothing was found");
  v.Real("cover_above_m", cover_above_m, length, "points this much higher lie on the target, m");
}

std::span<const RankingRow> RankingTable() { return kRankings; }

const RankingRow& RankingNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const RankingRow& row : kRankings) {
    if (name == row.name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("ranking", name, names));
}

}  // namespace pickbed
