#include "grasp/candidates/antipodal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "grasp/candidates/candidates.h"
#include "grasp/candidates/pad_contact.h"
#include "grasp/candidates/robustness.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/objects/contact.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// Two surface points that face away from each other along `axis_O` (unit, first to second).
struct ContactPair {
  Vector3d center_O;
  Vector3d axis_O;
};

Vector3d DirectionInCone(const Vector3d& axis, double half_angle_rad, Rng& rng) {
  const double cosine = rng.Uniform(std::cos(half_angle_rad), 1.0);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double turn = rng.Uniform(0, 2 * std::numbers::pi);
  const Vector3d u = axis.unitOrthogonal();
  return cosine * axis + sine * (std::cos(turn) * u + std::sin(turn) * axis.cross(u));
}

// Casts rays from the surface into the object. Every exit point within the stroke and the friction
// cone gives a pair, also behind a bore. HandClearsObject checks later whether the fingers can
// reach it.
std::vector<ContactPair> FindPairs(const ObjectModel& model, double cone_rad, double max_width_m,
                                   const AntipodalOptions& options, Rng& rng) {
  std::vector<ContactPair> pairs;
  const MeshQuery query(model.mesh_O);
  const SurfaceSamples samples = SampleSurface(model.mesh_O, options.max_samples, rng);
  for (size_t i = 0; i < samples.points.size(); ++i) {
    if (static_cast<int>(pairs.size()) >= options.max_pairs) break;
    const Vector3d inward = -samples.normals[i];
    const bool straight = rng.Uniform() < options.straight_share;
    const Vector3d axis = straight ? inward : DirectionInCone(inward, cone_rad, rng);
    for (const SurfaceHit& hit : query.AllHits(samples.points[i], axis)) {
      const double width = (hit.point - samples.points[i]).dot(axis);
      if (width < options.min_width_m || width > max_width_m) continue;
      if (hit.normal.dot(axis) < std::cos(cone_rad)) continue;
      pairs.push_back({0.5 * (hit.point + samples.points[i]), axis});
    }
  }
  return pairs;
}

// Frame G with closing axis x, rotated about it by `turn_rad`. The tips are `tips_beyond_m` past
// the center of the pair.
Pose GraspFrame(const ContactPair& pair, double turn_rad, double tips_beyond_m) {
  const Vector3d u = pair.axis_O.unitOrthogonal();
  const Vector3d v = pair.axis_O.cross(u);
  Eigen::Matrix3d R_OG;
  R_OG.col(0) = pair.axis_O;
  R_OG.col(2) = std::cos(turn_rad) * u + std::sin(turn_rad) * v;
  R_OG.col(1) = R_OG.col(2).cross(R_OG.col(0));
  return MakePose(R_OG, pair.center_O + tips_beyond_m * R_OG.col(2));
}

// Quality of candidates. The members are constant for one object and hand.
struct Judge {
  const ObjectModel& model;
  const HandSpec& hand;
  double clearance_m;
  const AntipodalOptions& options;
  const SurfacePoints& surface;
  double friction;
  double cone_rad;

  // Reduction of quality for the torque of the weight about the closing line, against the torsional
  // friction of the pads.
  double TorqueFactor(const Pose& X_OG, const PadContact& contact) const {
    const Eigen::Vector2d shared = contact.shared_center();
    const Vector3d com_G = X_OG.inverse() * model.mass.com_O;
    const double lever = (com_G.tail<2>() - shared).norm();
    // A uniformly pressed disc resists mu * N * 2/3 of its radius, on each of two pads.
    const double arm = 2.0 / 3.0 * std::sqrt(contact.area_m2 / std::numbers::pi);
    const double ratio =
        WrenchForce_n(model) * lever / (2 * friction * hand.force_n * std::max(arm, 1e-6));
    const double off_center = std::min(1.0, 2 * lever / model.diameter_m);
    return (1 - options.off_center_share * off_center) / (1 + ratio * ratio);
  }

  double Quality(const Pose& X_OG, const PadContact& contact) const {
    const Vector3d size = hand.finger_size_m;
    const double cone_factor = 1 - contact.max_angle_rad / std::atan(friction);
    const double share = contact.area_m2 / (size.y() * size.z());
    const double thin = options.thin_pad_factor;
    const double pad_factor = thin + (1 - thin) * std::min(1.0, share / options.full_pad_share);
    const double depth = -contact.shared_center().y();
    const double depth_factor = std::min(1.0, depth / options.good_depth_m);
    return cone_factor * pad_factor * depth_factor * TorqueFactor(X_OG, contact);
  }

  // Returns the candidate at this pose with its origin moved to the center of the contact; quality
  // 0 if there is no valid contact. `turned`: the surface points in the axes of G.
  GraspCandidate Evaluate(Pose X_OG, const PointColumns& turned) const {
    GraspCandidate candidate;
    const auto close = [&] { return ClosePads(surface, turned, X_OG, hand, options.touch_band_m); };
    const auto good = [&](const PadContact& contact) {
      return contact.touches && contact.shared() && contact.max_angle_rad <= cone_rad;
    };
    PadContact contact = close();
    if (!good(contact)) return candidate;
    X_OG.translate(
        Vector3d(0.5 * (contact.low_x_m + contact.high_x_m), contact.shared_center().x(), 0));
    contact = close();
    if (!good(contact)) return candidate;
    const auto opening = JawOpening_m(hand, clearance_m, contact.width_m());
    if (!opening) return candidate;
    const auto boxes = HandBoxes(hand, *opening);
    if (!HandClearsObject(turned, X_OG, boxes, options.own_margin_m)) return candidate;
    candidate.X_OG = X_OG;
    candidate.width_m = contact.width_m();
    candidate.depth_m = -contact.shared_center().y();
    candidate.quality = Quality(X_OG, contact);
    return candidate;
  }
};

bool SameGrasp(const GraspCandidate& a, const GraspCandidate& b, double spacing_m,
               double spacing_rad) {
  if ((a.X_OG.translation() - b.X_OG.translation()).norm() > spacing_m) return false;
  // A two-finger hand is identical after a rotation of pi about its approach axis.
  const Eigen::Matrix3d flipped =
      b.X_OG.linear() * Vector3d(-1, -1, 1).asDiagonal().toDenseMatrix();
  const double angle = std::min(RotationAngleRad(a.X_OG.linear(), b.X_OG.linear()),
                                RotationAngleRad(a.X_OG.linear(), flipped));
  return angle < spacing_rad;
}

// Up directions in which the object rests, and their images under its symmetries.
std::vector<Vector3d> RestingUps(const ObjectModel& model, const AntipodalOptions& options) {
  const auto symmetries = SymmetryTransforms(model.symmetries_O, options.resting_rotations);
  const double same = std::cos(options.resting_spacing_rad);
  std::vector<Vector3d> ups_O;
  for (const RestingDirection& resting : model.resting_O) {
    for (const Pose& X_OS : symmetries) {
      const Vector3d up_O = X_OS.linear() * resting.up_O;
      const bool known = std::any_of(ups_O.begin(), ups_O.end(),
                                     [&](const Vector3d& other) { return other.dot(up_O) > same; });
      if (!known) ups_O.push_back(up_O);
    }
  }
  return ups_O;
}

// Adds the candidates of one lean about the closing axis. The tips are `tips_beyond_m` past the
// center of the pair, or less where the floor limits them.
void AddLeaning(const Judge& judge, const ContactPair& pair, const Vector3d& up_O,
                const Eigen::Matrix3d& R_OG, double center_m, std::vector<GraspCandidate>& all) {
  const AntipodalOptions& options = judge.options;
  const double down = -up_O.dot(R_OG.col(2));
  const double half_width_m = 0.5 * judge.hand.finger_size_m.y();
  const double corner_m = half_width_m * std::abs(up_O.dot(R_OG.col(1)));
  const double max_m = (center_m - options.floor_gap_m - corner_m) / down;
  const PointColumns turned = Rotated(judge.surface.points_O, R_OG);
  double last_m = -1;
  for (const double wanted_m : options.tips_beyond_m) {
    const double beyond_m = std::min(wanted_m, max_m);
    if (beyond_m <= 0 || beyond_m == last_m) continue;
    last_m = beyond_m;
    const GraspCandidate candidate =
        judge.Evaluate(MakePose(R_OG, pair.center_O + beyond_m * R_OG.col(2)), turned);
    if (candidate.quality > 0) all.push_back(candidate);
  }
}

// Adds grasps for an object that rests with `up_O` up.
void AddRestingGrasps(const Judge& judge, const std::vector<ContactPair>& pairs,
                      const Vector3d& up_O, std::vector<GraspCandidate>& all) {
  const AntipodalOptions& options = judge.options;
  double floor_m = std::numeric_limits<double>::infinity();
  for (const Vector3d& p_O : judge.model.mesh_O.vertices) {
    floor_m = std::min(floor_m, up_O.dot(p_O));
  }
  for (const ContactPair& pair : pairs) {
    const double slope = pair.axis_O.dot(up_O);
    if (std::abs(slope) > std::sin(options.resting_level_rad)) continue;
    Eigen::Matrix3d R_OG;
    R_OG.col(0) = (pair.axis_O - slope * up_O).normalized();
    R_OG.col(2) = -up_O;
    R_OG.col(1) = R_OG.col(2).cross(R_OG.col(0));
    const double center_m = up_O.dot(pair.center_O) - floor_m;
    for (int lean = -options.resting_leans; lean <= options.resting_leans; ++lean) {
      const Eigen::AngleAxisd turn(lean * options.resting_lean_rad, Vector3d::UnitX());
      AddLeaning(judge, pair, up_O, R_OG * turn.toRotationMatrix(), center_m, all);
    }
  }
}

}  // namespace

void AntipodalOptions::Visit(SettingsVisitor& v) {
  v.Integer("candidates", candidates, {1, 100000}, "maximum number of candidates per object");
  v.Integer("max_samples", max_samples, {1, 1e7}, "maximum number of sampled surface points");
  v.Integer("max_pairs", max_pairs, {1, 1e6}, "maximum number of antipodal pairs");
  v.Integer("approaches", approaches, {1, 360}, "approach directions around the closing axis");
  v.Real("cone_share", cone_share, {0.01, 1},
         "share of the friction cone's half angle that is used");
  v.Real("straight_share", straight_share, {0, 1}, "share of the rays along the surface normal");
  v.Vector3("tips_beyond_m", tips_beyond_m, {0, 0.05},
            "distances of the fingertips beyond the contact, m");
  v.Real("point_spacing_m", point_spacing_m, {1e-4, 0.02},
         "spacing of the tested surface points, m");
  v.Integer("min_points", min_points, {100, 1e6}, "minimum number of tested surface points");
  v.Integer("max_points", max_points, {100, 1e6}, "maximum number of tested surface points");
  v.Integer("resting_candidates", resting_candidates, {0, 100000},
            "maximum number of additional candidates for objects at rest");
  v.Real("resting_lean_rad", resting_lean_rad, {0, 0.7}, "angle between leans of the hand, rad");
  v.Integer("resting_leans", resting_leans, {0, 2}, "number of leans of the hand to each side");
  v.RenamedKey("resting_turns", "resting_rotations");
  v.Integer("resting_rotations", resting_rotations, {1, 1000},
            "sampled rotations of a continuous symmetry");
  v.Real("resting_level_rad", resting_level_rad, {0, 1},
         "angle from horizontal within which pairs are made horizontal, rad");
  v.Real("floor_gap_m", floor_gap_m, {0, 0.1}, "distance of the fingertips from the floor, m");
  v.Real("resting_spacing_rad", resting_spacing_rad, {0, 3.2},
         "rotation within which resting candidates are duplicates, rad");
  v.Real("min_width_m", min_width_m, {1e-4, 0.1}, "minimum thickness of a grasped wall, m");
  v.Real("touch_band_m", touch_band_m, {1e-5, 0.01},
         "depth of the surface band that counts as contact, m");
  v.Real("full_pad_share", full_pad_share, {0.01, 1},
         "share of a pad in contact from which quality is full");
  v.Real("thin_pad_factor", thin_pad_factor, {0, 1}, "quality factor of a contact without area");
  v.Real("off_center_share", off_center_share, {0, 1},
         "share of quality lost at half a diameter from the center of mass");
  v.Real("good_depth_m", good_depth_m, {1e-4, 0.1},
         "depth of the contact behind the tips from which quality is full, m");
  v.Real("own_margin_m", own_margin_m, {0, 0.02}, "distance between open hand and object, m");
  v.Real("spacing_m", spacing_m, {0, 0.1}, "distance within which candidates are duplicates, m");
  v.Real("spacing_rad", spacing_rad, {0, 3.2},
         "rotation within which candidates are duplicates, rad");
}

std::vector<GraspCandidate> AntipodalGrasps(const ObjectModel& model, const HandSpec& hand,
                                            double clearance_m, Rng& rng,
                                            const AntipodalOptions& options) {
  CheckSettings("AntipodalOptions", options);
  const double friction = PairFriction(model.friction, hand.pad_friction);
  const double cone_rad = options.cone_share * std::atan(friction);
  const double max_width = hand.stroke_m - 2 * clearance_m;
  const auto pairs = FindPairs(model, cone_rad, max_width, options, rng);
  if (pairs.empty()) return {};
  const SurfacePoints surface = SpreadPoints(model.mesh_O, options.point_spacing_m,
                                             options.min_points, options.max_points, rng);
  const Judge judge{model, hand, clearance_m, options, surface, friction, cone_rad};

  std::vector<GraspCandidate> all;
  for (const ContactPair& pair : pairs) {
    const double first_turn = rng.Uniform(0, 2 * std::numbers::pi);
    for (int k = 0; k < options.approaches; ++k) {
      const double turn = first_turn + 2 * std::numbers::pi * k / options.approaches;
      const PointColumns turned = Rotated(surface.points_O, GraspFrame(pair, turn, 0).linear());
      for (const double tips_beyond : options.tips_beyond_m) {
        const GraspCandidate candidate =
            judge.Evaluate(GraspFrame(pair, turn, tips_beyond), turned);
        if (candidate.quality > 0) all.push_back(candidate);
      }
    }
  }
  auto chosen =
      SpreadOverDirections(std::move(all), options.candidates, [&](const auto& a, const auto& b) {
        return SameGrasp(a, b, options.spacing_m, options.spacing_rad);
      });
  std::vector<GraspCandidate> resting;
  for (const Vector3d& up_O : RestingUps(model, options)) {
    AddRestingGrasps(judge, pairs, up_O, resting);
  }
  resting = SpreadOverDirections(
      std::move(resting), options.resting_candidates, [&](const auto& a, const auto& b) {
        return SameGrasp(a, b, options.spacing_m, options.resting_spacing_rad);
      });
  chosen.insert(chosen.end(), resting.begin(), resting.end());
  return chosen;
}

}  // namespace pickbed::grasp
