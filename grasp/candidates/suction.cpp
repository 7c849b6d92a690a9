#include "grasp/candidates/suction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "grasp/candidates/candidates.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/objects/contact.h"
#include "sim/hands/suction_seal.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

constexpr int kRimPoints = 8;

// Frame G on a surface point, pressed in by `press_m`.
Pose LipFrame(const Vector3d& point_O, const Vector3d& normal_O, double press_m) {
  Eigen::Matrix3d R_OG;
  R_OG.col(2) = -normal_O;
  R_OG.col(0) = normal_O.unitOrthogonal();
  R_OG.col(1) = R_OG.col(2).cross(R_OG.col(0));
  return MakePose(R_OG, point_O - press_m * normal_O);
}

double Quality(const ObjectModel& model, const CupSpec& cup, const Pose& X_OG, const CupSeal& seal,
               double max_tilt_rad) {
  const double lever_m = (X_OG.inverse() * model.mass.com_O).head<2>().norm();
  const double ratio = WrenchForce_n(model) * lever_m / cup.moment_limit_nm;
  const double off_center = std::min(1.0, 2 * lever_m / model.diameter_m);
  const double flat = cup.lip_conform_m > 0 ? 1 - seal.uneven_m / cup.lip_conform_m : 1;
  const double upright = 1 - seal.tilt_rad / max_tilt_rad;
  return std::max(0.0, flat) * std::max(0.0, upright) * (1 - 0.5 * off_center) /
         (1 + ratio * ratio);
}

bool SameGrasp(const GraspCandidate& a, const GraspCandidate& b, const SuctionOptions& options) {
  return (a.X_OG.translation() - b.X_OG.translation()).norm() <= options.spacing_m &&
         a.X_OG.linear().col(2).dot(b.X_OG.linear().col(2)) > std::cos(options.spacing_rad);
}

}  // namespace

void SuctionOptions::Visit(SettingsVisitor& v) {
  v.Integer("candidates", candidates, {1, 100000}, "maximum number of candidates per object");
  v.Integer("max_samples", max_samples, {1, 1e7}, "number of sampled surface points");
  v.Real("point_spacing_m", point_spacing_m, {1e-4, 0.02},
         "spacing of the tested surface points, m");
  v.Integer("min_points", min_points, {100, 1e6}, "minimum number of tested surface points");
  v.Integer("max_points", max_points, {100, 1e6}, "maximum number of tested surface points");
  v.Real("own_margin_m", own_margin_m, {0, 0.02}, "distance between stem and object, m");
  v.Real("max_tilt_rad", max_tilt_rad, {0.01, 1.5},
         "tilt of the lip's plane at which the quality is 0, rad");
  v.Real("spacing_m", spacing_m, {0, 0.1}, "distance within which candidates are duplicates, m");
  v.Real("spacing_rad", spacing_rad, {0, 3.2},
         "rotation within which candidates are duplicates, rad");
}

WrenchSet CupWrenches(const ObjectModel& model, const CupSpec& cup, const Pose& X_OG,
                      double compression_m, double friction_factor, int cone_edges) {
  const double force = cup.vacuum_n / WrenchForce_n(model);
  const double radius_m = RingRadius_m(cup);
  const Vector3d approach = X_OG.linear().col(2);
  const Vector3d center = X_OG * Vector3d(0, 0, -compression_m) - model.mass.com_O;
  WrenchSet set;
  Wrenches rim(6, kRimPoints * cone_edges);
  for (int k = 0; k < kRimPoints; ++k) {
    const double turn = 2 * std::numbers::pi * k / kRimPoints;
    const Vector3d arm = X_OG.linear() * Vector3d(std::cos(turn), std::sin(turn), 0);
    const ContactCone cone{center + radius_m * arm, approach, 2 * force,
                           friction_factor * PairFriction(model.friction, cup.friction)};
    rim.middleCols(k * cone_edges, cone_edges) = ConeEdges(cone, cone_edges, WrenchRadius_m(model));
  }
  set.regions.push_back(std::move(rim));
  const Vector3d pull = -force * approach;
  set.offset << pull, center.cross(pull) / WrenchRadius_m(model);
  return set;
}

std::vector<GraspCandidate> SuctionGrasps(const ObjectModel& model, const CupSpec& cup, Rng& rng,
                                          const SuctionOptions& options,
                                          const RobustOptions& robust) {
  CheckSettings("SuctionOptions", options);
  CheckSettings("RobustOptions", robust);
  const MeshQuery mesh(model.mesh_O);
  const auto boxes = CupBoxes(cup);
  const SurfacePoints surface = SpreadPoints(model.mesh_O, options.point_spacing_m,
                                             options.min_points, options.max_points, rng);
  const auto clears = [&](const Pose& X_OG, double margin_m) {
    return HandClearsObject(Rotated(surface.points_O, X_OG.linear()), X_OG, boxes, margin_m);
  };
  const SurfaceSamples samples = SampleSurface(model.mesh_O, options.max_samples, rng);
  std::vector<GraspCandidate> all;
  for (size_t i = 0; i < samples.points.size(); ++i) {
    GraspCandidate candidate;
    candidate.X_OG = LipFrame(samples.points[i], samples.normals[i], cup.press_m);
    const CupSeal seal = TestSeal(mesh, candidate.X_OG, cup);
    if (!seal.sealed() || !clears(candidate.X_OG, options.own_margin_m)) continue;
    candidate.quality = Quality(model, cup, candidate.X_OG, seal, options.max_tilt_rad);
    if (candidate.quality > 0) all.push_back(candidate);
  }
  auto chosen =
      SpreadOverDirections(std::move(all), options.candidates,
                           [&](const auto& a, const auto& b) { return SameGrasp(a, b, options); });

  const Rng errors(rng.Next());
  const auto hold = [&](const Pose& X_OG, double factor) -> std::optional<WrenchSet> {
    const CupSeal seal = TestSeal(mesh, X_OG, cup);
    if (!seal.sealed() || !clears(X_OG, 0)) return std::nullopt;
    return CupWrenches(model, cup, X_OG, seal.compression_m, factor, robust.cone_edges);
  };
  for (GraspCandidate& candidate : chosen) {
    if (const auto set = hold(candidate.X_OG, 1)) candidate.epsilon = DepthOfZero(*set).lower;
    candidate.robust = RobustShare(model, candidate.X_OG, hold, errors, robust);
  }
  return chosen;
}

}  // namespace pickbed::grasp
