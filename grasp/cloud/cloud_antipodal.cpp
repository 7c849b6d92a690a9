#include "grasp/cloud/cloud_antipodal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "grasp/plan/clearance.h"
#include "scenes/base/error.h"
#include "scenes/base/math.h"

namespace pickbed::grasp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A grasp in B before the last checks.
struct Found {
  Pose X_BG;
  double width_m = 0;
  double score = 0;
  size_t tool = 0;
};

Matrix3d Orientation(const Vector3d& approach_B, double closing_rad) {
  // The closing direction at angle 0 is as near to x of B as the approach permits.
  const Vector3d x0 = (Vector3d::UnitX() - approach_B * approach_B.x()).normalized();
  Matrix3d R_BG;
  R_BG.col(2) = approach_B;
  R_BG.col(0) = Eigen::AngleAxisd(closing_rad, approach_B) * x0;
  R_BG.col(1) = R_BG.col(2).cross(R_BG.col(0));
  return R_BG;
}

// Whether two grasps are nearly the same. Opposite closing directions are one.
bool AreNear(const Found& a, const Found& b, const CloudAntipodalOptions& options) {
  if ((a.X_BG.translation() - b.X_BG.translation()).norm() > options.apart_m) return false;
  const double cosine = std::cos(options.apart_rad);
  return std::abs(a.X_BG.linear().col(0).dot(b.X_BG.linear().col(0))) > cosine &&
         a.X_BG.linear().col(2).dot(b.X_BG.linear().col(2)) > cosine;
}

void AddRejections(const FaceRejections& rejected, PlanResult& result) {
  const auto add = [&](const char* cause, int count) {
    if (count > 0) result.rejected[cause] += count;
  };
  add("no room for the fingers", rejected.no_room);
  add("palm meets an instance", rejected.palm);
  add("two instances between the fingers", rejected.two_segments);
  add("faces outside the friction cone", rejected.friction);
  add("too little to hold", rejected.shallow);
}

}  // namespace

void CloudAntipodalOptions::Visit(SettingsVisitor& v) {
  v.Integer("angles", angles, {1, 360}, "number of closing directions of a vertical approach");
  v.Integer("tilts", tilts, {0, 36}, "number of directions into which the approach is tilted");
  v.Integer("tilted_angles", tilted_angles, {1, 360},
            "number of closing directions of a tilted approach");
  v.Real("tilt_share", tilt_share, {0, 1}, "share of the score that is lost at the largest tilt");
  v.Real("min_score", min_score, {0, 1}, "minimum score of a reported grasp");
  v.Real("bin_clearance_m", bin_clearance_m, {0, 0.1}, "distance between hand and bin, m");
  v.Real("apart_m", apart_m, {0, 0.1}, "minimum distance of two reported grasps, m");
  v.Real("apart_rad", apart_rad, {0, 3.2}, "minimum angle between two reported grasps, rad");
  v.Group(
      "surface", [this](SettingsVisitor& g) { surface.Visit(g); }, "surface that the image shows");
  v.Group(
      "faces", [this](SettingsVisitor& g) { faces.Visit(g); }, "opposing faces of the surface");
}

std::vector<Matrix3d> HandOrientations(const CloudAntipodalOptions& options, double max_tilt_rad) {
  constexpr double kPi = std::numbers::pi;
  std::vector<Matrix3d> orientations;
  for (int i = 0; i < options.angles; ++i) {
    orientations.push_back(Orientation(-Vector3d::UnitZ(), kPi * i / options.angles));
  }
  if (!(max_tilt_rad > 0)) return orientations;
  for (int t = 0; t < options.tilts; ++t) {
    const double azimuth = 2 * kPi * t / options.tilts;
    const Vector3d approach(std::sin(max_tilt_rad) * std::cos(azimuth),
                            std::sin(max_tilt_rad) * std::sin(azimuth), -std::cos(max_tilt_rad));
    for (int i = 0; i < options.tilted_angles; ++i) {
      orientations.push_back(Orientation(approach, kPi * i / options.tilted_angles));
    }
  }
  return orientations;
}

CloudAntipodal::CloudAntipodal(const PlannerSetup& setup, const CloudAntipodalOptions& options)
    : spec_(setup.spec),
      options_(options),
      R_BG_(HandOrientations(options, Radians(setup.spec.max_tilt_deg))) {
  CheckSettings("CloudAntipodalOptions", options_);
  for (const auto& tool : setup.tools) {
    const auto* jaw = dynamic_cast<const ParallelJaw*>(tool.get());
    CheckInput(jaw != nullptr,
               fmt::format("planner cloud_antipodal needs parallel jaws, but gripper {} is a {}; "
                           "choose a jaw of `pickbed list grippers` or planner {}",
                           tool->name, tool->mechanism(), kPosePlanner));
    jaws_.push_back(jaw);
  }
}

PlanResult CloudAntipodal::Plan(const PlannerInput& input) {
  PlanResult result;
  const ObservedSurface surface =
      ObserveSurface(input.frame, input.X_WC, input.bin, options_.surface);
  const Bin* bin = input.bin ? &input.bin->bin : nullptr;
  std::vector<Found> found;
  FaceRejections rejected;
  for (const Matrix3d& R_BG : R_BG_) {
    const HeightMap map = MakeHeightMap(surface, R_BG, options_.faces.cell_m, bin);
    const double tilt_rad = std::acos(std::clamp(-R_BG(2, 2), -1.0, 1.0));
    const double max_tilt_rad = std::max(1e-9, Radians(spec_.max_tilt_deg));
    const double tilt_factor = 1 - options_.tilt_share * tilt_rad / max_tilt_rad;
    for (size_t k = 0; k < jaws_.size(); ++k) {
      const std::vector<FacePair> pairs =
          FindFacePairs(map, surface.segments, jaws_[k]->hand, jaws_[k]->clearance_m,
                        spec_.friction, options_.faces, rejected);
      for (const FacePair& pair : pairs) {
        Found& grasp = found.emplace_back();
        grasp.X_BG = MakePose(R_BG, map.PointIn_B(pair.x_m, pair.y_m, pair.tips_m));
        grasp.width_m = pair.width_m;
        grasp.score = pair.score * tilt_factor;
        grasp.tool = k;
        if (grasp.score < options_.min_score) {
          found.pop_back();
          ++result.rejected["score too low"];
        }
      }
    }
  }
  AddRejections(rejected, result);
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.score > b.score; });
  const std::vector<AxisAlignedBox> bin_boxes =
      bin != nullptr ? BinBoxes(*bin) : std::vector<AxisAlignedBox>();
  const Pose X_WB = input.bin ? input.bin->X_WB : Pose::Identity();
  std::vector<Found> kept;
  for (const Found& grasp : found) {
    const bool is_known = std::any_of(kept.begin(), kept.end(), [&](const Found& better) {
      return AreNear(grasp, better, options_);
    });
    if (is_known) continue;
    if (static_cast<int>(kept.size()) == input.max_grasps) {
      ++result.rejected["outranked"];
      continue;
    }
    const ParallelJaw& jaw = *jaws_[grasp.tool];
    const std::optional<double> opening_m = jaw.ApproachOpening_m(grasp.width_m);
    if (!opening_m ||
        HandMeetsBin(jaw, *opening_m, grasp.X_BG, bin_boxes, options_.bin_clearance_m)) {
      ++result.rejected["bin wall"];
      continue;
    }
    kept.push_back(grasp);
    result.grasps.push_back(
        {X_WB * grasp.X_BG, grasp.width_m, grasp.score, kNoHypothesis, jaw.name});
  }
  return result;
}

}  // namespace pickbed::grasp
