#include "sim/drop/distractors.h"

#include <fmt/format.h>

#include <stdexcept>

#include "scenes/base/random.h"
#include "sim/convex/convex_hull.h"

namespace pickbed::sim {
namespace {

// Returns points on a sphere that is then scaled along two axes. All of them stay corners of the
// hull. The shapes are plates, rods, wedges and lumps.
std::vector<Eigen::Vector3d> RandomCorners(const DistractorOptions& options, Rng& rng) {
  const int count = options.corners_min + rng.Index(options.corners_max - options.corners_min + 1);
  const Eigen::Vector3d squeeze(1, rng.Uniform(options.flattest, 1),
                                rng.Uniform(options.flattest, 1));
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < count; ++i) corners.push_back(squeeze.cwiseProduct(rng.UnitVector()));
  return corners;
}

std::shared_ptr<const ObjectModel> RandomShape(double diameter_m, const DistractorOptions& options,
                                               Rng& rng) {
  ConvexHull hull;
  do {
    hull = MakeConvexHull(RandomCorners(options, rng));
  } while (hull.vertices.empty());  // four points may be in one plane
  auto model = std::make_shared<ObjectModel>();
  model->mesh_O.vertices = hull.vertices;
  model->mesh_O.triangles = hull.triangles;
  const double scale = diameter_m / Diameter(model->mesh_O);
  for (Eigen::Vector3d& vertex : model->mesh_O.vertices) vertex *= scale;
  model->convex_pieces_O = {{model->mesh_O.vertices}};
  model->mass = UniformMassProperties(
      model->mesh_O, options.density_kgpm3 * hull.Volume() * scale * scale * scale);
  model->diameter_m = diameter_m;
  model->mesh_hash = MeshHash(model->mesh_O);
  return model;
}

}  // namespace

void DistractorOptions::Validate() const {
  const bool good = per_object >= 1 && corners_min >= 4 && corners_max >= corners_min &&
                    diameter_min > 0 && diameter_max >= diameter_min && flattest > 0 &&
                    flattest <= 1 && density_kgpm3 > 0;
  if (!good) throw std::logic_error("distractor options out of range");
}

ObjectSet MakeDistractors(const ObjectSet& objects, const DistractorOptions& options) {
  options.Validate();
  ObjectSet shapes;
  for (const auto& object : objects) {
    for (int i = 0; i < options.per_object; ++i) {
      Rng rng = Rng::Derive(options.seed, i, "foreign part");
      const double share = rng.Uniform(options.diameter_min, options.diameter_max);
      shapes.push_back(RandomShape(share * object->diameter_m, options, rng));
    }
  }
  return shapes;
}

}  // namespace pickbed::sim
