#include "sim/physics/body_shapes.h"

#include <algorithm>

#include "scenes/geometry/decompositions.h"
#include "sim/physics/bullet_types.h"

namespace pickbed::sim {
namespace {

// Below this diameter, the hull margin is proportional to the diameter.
constexpr double kFullMarginDiameter_m = 0.04;

BodyFrame PrincipalFrame(const MassProperties& mass) {
  const SymmetricEigen3 principal = EigenOfSymmetric3(mass.inertia_com_O);
  Eigen::Matrix3d R_OB = principal.vectors;
  if (R_OB.determinant() < 0) R_OB.col(2) *= -1;
  return {MakePose(R_OB, mass.com_O), principal.values};
}

}  // namespace

const BodyShape& BodyShapes::Of(const ObjectModel& model) {
  const auto [entry, is_new] = made_.try_emplace(&model);
  if (!is_new) return entry->second;
  BodyShape& made = entry->second;
  made.frame = PrincipalFrame(model.mass);
  const Pose X_BO = made.frame.X_OB.inverse();
  const double margin =
      kUnitsPerMeter * hull_margin_m_ * std::min(1.0, model.diameter_m / kFullMarginDiameter_m);
  const bool single = model.convex_pieces_O.size() == 1;
  auto compound =
      std::make_unique<btCompoundShape>(true, static_cast<int>(model.convex_pieces_O.size()));
  compound->setMargin(margin);
  for (const ConvexPiece& piece : model.convex_pieces_O) {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Eigen::Vector3d& p_O : piece.vertices_O) {
      hull->addPoint(ToBullet(Eigen::Vector3d(X_BO * p_O)), false);
    }
    hull->setMargin(margin);
    hull->recalcLocalAabb();
    if (!single) compound->addChildShape(btTransform::getIdentity(), hull.get());
    made.shape = hull.get();
    shapes_.push_back(std::move(hull));
  }
  if (!single) {
    made.shape = compound.get();
    shapes_.push_back(std::move(compound));
  }
  return made;
}

}  // namespace pickbed::sim
