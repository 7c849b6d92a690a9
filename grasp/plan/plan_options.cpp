#include <array>
#include <numbers>

#include "grasp/plan/plan.h"
#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

constexpr std::array<RankingRow, 5> kRankings{{
    {"quality", "quality from angle, area, depth and lever arm of the contacts, 0 to 1",
     [](const GraspCandidate& candidate) { return candidate.quality; }, true},
    {"epsilon", "smallest load from any direction that the contacts cannot balance",
     [](const GraspCandidate& candidate) { return candidate.epsilon / (1 + candidate.epsilon); }},
    {"robust", "share of sampled errors under which the grasp holds",
     [](const GraspCandidate& candidate) { return candidate.robust; }},
    {"tolerance", "probability that the grasp survives the pose error, by a tolerance map",
     [](const GraspCandidate& candidate) { return candidate.tolerance; }},
    {"random", "random order of the grasps without collision, as a baseline", nullptr},
}};

}  // namespace

void RelaxedConstraints::Visit(SettingsVisitor& v) {
  v.RenamedKey("look", "enabled");
  v.Bool("enabled", enabled,
         "whether planning is repeated with these limits if no grasp was found");
  v.Real("max_tilt_rad", max_tilt_rad, {0.01, std::numbers::pi},
         "maximum angle of the approach from straight down, rad");
  v.Real("min_quality", min_quality, {0, 1}, "minimum quality of a candidate");
  v.Real("clearance_share", clearance_share, {-2, 1},
         "share of the gripper's clearance that is kept");
  v.Real("bin_clearance_m", bin_clearance_m, {0, 0.1}, "distance between hand and bin, m");
}

void PlanOptions::Visit(SettingsVisitor& v) {
  const Range share{0, 1};
  const Range length{0, 0.1};
  v.Integer("max_grasps", max_grasps, {1, 100000}, "maximum number of reported grasps");
  std::vector<std::string> rankings;
  for (const RankingRow& row : kRankings) rankings.push_back(row.name);
  v.Text("ranking", ranking, rankings, "criterion that orders the grasps");
  v.Seed("seed", seed, "random seed of the ranking random");
  v.Real("max_tilt_rad", max_tilt_rad, {0.01, std::numbers::pi},
         "maximum angle of the approach from straight down, rad");
  v.Real("own_points_m", own_points_m, {0.001, 0.1},
         "cloud points closer than this to the target's surface belong to it, m");
  v.Real("clearance_share", clearance_share, {-2, 1},
         "share of the gripper's clearance that is kept");
  v.Real("bin_clearance_m", bin_clearance_m, length, "distance between hand and bin, m");
  v.Real("min_depth_m", min_depth_m, length, "minimum depth of the contact behind the tips, m");
  v.Real("good_depth_m", good_depth_m, {0.001, 0.1},
         "depth of the contact behind the tips from which there is no loss, m");
  v.Real("min_quality", min_quality, share, "minimum quality of a candidate");
  v.Real("voxel_m", voxel_m, {0.0005, 0.1}, "voxel size to which the cloud is thinned, m");
  v.Real("bin_band_m", bin_band_m, length,
         "cloud points closer than this to floor and walls belong to the bin, m");
  v.Real("neighbor_confidence", neighbor_confidence, {0, kNoNeighbors},
         "minimum confidence of an estimated pose that is an obstacle");
  v.Real("neighbor_spacing_m", neighbor_spacing_m, {0.001, 0.1},
         "spacing of the points on the poses that are obstacles, m");
  v.Real("same_share", same_share, share,
         "poses closer than this share of the diameter can be the same instance");
  v.Real("same_thickness_share", same_thickness_share, share,
         "poses closer than this share of the minimum extent can be the same instance");
  v.Real("height_share", height_share, share, "share of the score that the lowest instance loses");
  v.Real("tilt_share", tilt_share, share, "share of the score that is lost at max_tilt_rad");
  v.Real("room_share", room_share, share,
         "share of the score that is lost if others touch the hand");
  v.Real("cover_share", cover_share, share,
         "share of the score that is lost if others cover the whole target");
  v.Real("stacking_share", stacking_share, share,
         "share of the score that is lost for each instance above the target");
  v.Real("stacking_cell_m", stacking_cell_m, {0.001, 0.1},
         "cell size of the floor plan in which instances above are found, m");
  v.Real("lift_aside_diameters", lift_aside_diameters, {0, 1},
         "shift of the lift away from instances above the target, diameters; 0 = straight up");
  v.Real("aside_share", aside_share, share,
         "share of the score that is lost if the hand is shifted away from a wall");
  v.RenamedKey("set_down_share", "place_share");
  v.Real("place_share", place_share, share,
         "share of the score that is lost if the object cannot be set down with this grasp");
  v.Real(
      "lift_load", lift_load, {0, 10},
      "load at the start of the lift, weights of the object; a hold that breaks under it has half "
      "of the score, 0 = ignored");
  v.Real("load_share", load_share, share,
         "share of the score that is lost if the contacts resist no load from some direction; only "
         "for ranking quality");
  v.Real("between_share", between_share, share,
         "share of the score that is lost if others are between the fingers");
  v.Real("hidden_share", hidden_share, share,
         "share of the score that is lost if the hand enters much space that the image does not "
         "show");
  v.Real("full_hidden_m", full_hidden_m, {0.001, 1},
         "mean depth of the fingers in hidden space at which the loss is full, m");
  v.Real("hidden_behind_m", hidden_behind_m, length,
         "what is less far behind an observed surface counts as seen, m");
  v.Real("hidden_step_m", hidden_step_m, {0.0005, 0.1},
         "spacing of the points at which the hand is tested for hidden space, m");
  v.Real("good_room_m", good_room_m, {0.001, 0.1},
         "distance from others from which there is no loss, m");
  v.Integer("many_between", many_between, {1, 100000},
            "number of points between the fingers at which the loss is full");
  v.Real("column_m", column_m, {0.001, 0.1}, "cell size of the floor-plan grid of the points, m");
  v.RenamedKey("min_part_points", "min_object_points");
  v.Integer("min_object_points", min_object_points, {10, 100000},
            "minimum number of points on an estimated pose");
  v.RenamedKey("max_part_points", "max_object_points");
  v.Integer("max_object_points", max_object_points, {10, 100000},
            "maximum number of points on an estimated pose");
  v.RenamedKey("wide", "relaxed");
  v.Group(
      "relaxed", [this](SettingsVisitor& g) { relaxed.Visit(g); },
      "limits of a second planning if no grasp was found");
  v.Real("cover_above_m", cover_above_m, length,
         "points higher than this above the target cover it, m");
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

}  // namespace pickbed::grasp
