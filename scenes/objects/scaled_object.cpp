#include "scenes/objects/scaled_object.h"

#include <cmath>

namespace pickbed::scenes {

ObjectModel ScaledObject(const ObjectModel& model, double factor) {
  ObjectModel scaled = model;
  scaled.mesh_O = Scaled(model.mesh_O, factor);
  scaled.mass.mass_kg *= std::pow(factor, 3);
  scaled.mass.volume_m3 *= std::pow(factor, 3);
  scaled.mass.com_O *= factor;
  scaled.mass.inertia_com_O *= std::pow(factor, 5);
  for (Pose& S_O : scaled.symmetries_O.discrete_O) S_O.translation() *= factor;
  for (ContinuousSymmetry& axis : scaled.symmetries_O.continuous_O) axis.offset_O *= factor;
  for (ConvexPiece& piece : scaled.convex_pieces_O) {
    for (Eigen::Vector3d& p_O : piece.vertices_O) p_O *= factor;
  }
  scaled.diameter_m *= factor;
  scaled.mesh_hash = MeshHash(scaled.mesh_O);
  return scaled;
}

}  // namespace pickbed::scenes
