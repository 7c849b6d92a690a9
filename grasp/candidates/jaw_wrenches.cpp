#include "grasp/candidates/jaw_wrenches.h"

#include <algorithm>
#include <numbers>

#include "scenes/objects/contact.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRimDirections = 8;

}  // namespace

std::vector<Vector3d> RimPoints(const PadPatch& patch) {
  if (patch.points_G.empty()) return {};
  const double count = static_cast<double>(patch.points_G.size());
  Vector3d center = Vector3d::Zero();
  for (const Vector3d& p : patch.points_G) center += p / count;
  double mean_distance = 0;
  for (const Vector3d& p : patch.points_G) mean_distance += (p - center).tail<2>().norm() / count;

  std::vector<const Vector3d*> rim;
  for (int k = 0; k < kRimDirections; ++k) {
    const double turn = 2 * std::numbers::pi * k / kRimDirections;
    const Vector2d direction(std::cos(turn), std::sin(turn));
    const auto& points = patch.points_G;
    const Vector3d* furthest =
        &*std::max_element(points.begin(), points.end(), [&](const Vector3d& a, const Vector3d& b) {
          return a.tail<2>().dot(direction) < b.tail<2>().dot(direction);
        });
    if (std::find(rim.begin(), rim.end(), furthest) == rim.end()) rim.push_back(furthest);
  }
  double rim_distance = 0;
  for (const Vector3d* p : rim) rim_distance += (*p - center).tail<2>().norm() / rim.size();
  const double share = rim_distance > 0 ? std::min(1.0, mean_distance / rim_distance) : 1;
  std::vector<Vector3d> drawn_in;
  for (const Vector3d* p : rim) drawn_in.push_back(center + share * (*p - center));
  return drawn_in;
}

std::optional<WrenchSet> JawHold::At(const Pose& X_OG, double opening_m,
                                     double friction_factor) const {
  const PointColumns turned = Rotated(surface.points_O, X_OG.linear());
  const auto boxes = HandBoxes(hand, opening_m);
  if (!HandClearsObject(turned, X_OG, boxes, 0)) return std::nullopt;
  const PadContact contact = ClosePads(surface, turned, X_OG, hand, options.touch_band_m);
  if (!contact.touches) return std::nullopt;
  const auto patches = TouchedPatches(surface, turned, X_OG, hand, contact, options.touch_band_m);
  const double friction = friction_factor * PairFriction(model.friction, hand.pad_friction);
  WrenchSet set;
  for (const PadPatch& patch : patches) {
    // Rounding can exclude a point at the limit of the band.
    if (patch.points_G.empty()) return std::nullopt;
    const std::vector<Vector3d> rim = RimPoints(patch);
    Wrenches region(6, rim.size() * options.cone_edges);
    for (size_t i = 0; i < rim.size(); ++i) {
      const ContactCone cone{X_OG * rim[i] - model.mass.com_O, -(X_OG.linear() * patch.normal_G),
                             hand.force_n / WrenchForce_n(model), friction};
      region.middleCols(i * options.cone_edges, options.cone_edges) =
          ConeEdges(cone, options.cone_edges, WrenchRadius_m(model));
    }
    set.regions.push_back(std::move(region));
  }
  return set;
}

void SetJawEpsilon(const ObjectModel& model, const HandSpec& hand, double clearance_m,
                   const SurfacePoints& surface, const RobustOptions& options,
                   std::vector<GraspCandidate>& candidates, const WrenchDepthOptions& depth) {
  const JawHold jaw{model, hand, surface, options};
  for (GraspCandidate& candidate : candidates) {
    const auto opening = JawOpening_m(hand, clearance_m, candidate.width_m);
    if (!opening) continue;
    if (const auto set = jaw.At(candidate.X_OG, *opening, 1)) {
      candidate.epsilon = DepthOfZero(*set, depth).lower;
    }
  }
}

void JudgeJawGrasps(const ObjectModel& model, const HandSpec& hand, double clearance_m,
                    const SurfacePoints& surface, const RobustOptions& options, uint64_t seed,
                    std::vector<GraspCandidate>& candidates) {
  SetJawEpsilon(model, hand, clearance_m, surface, options, candidates);
  const JawHold jaw{model, hand, surface, options};
  for (GraspCandidate& candidate : candidates) {
    const auto opening = JawOpening_m(hand, clearance_m, candidate.width_m);
    if (!opening) continue;
    const auto hold = [&](const Pose& X_OG, double factor) {
      return jaw.At(X_OG, *opening, factor);
    };
    candidate.robust = RobustShare(model, candidate.X_OG, hold, Rng(seed), options);
  }
}

}  // namespace pickbed::grasp
