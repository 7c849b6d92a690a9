#include "scenes/objects/sampled_object.h"

#include "scenes/shape_families/mesh_cache.h"
#include "scenes/shape_families/sampled_names.h"

namespace pickbed::scenes {

ObjectModel SampledObject(const std::string& name, const SampledShape& shape) {
  ObjectModel model;
  model.name = name;
  model.mesh_O = CachedMeshOfSolid(shape.solid);
  model.mesh_O.base_color = SampledColor(shape);
  model.mass = UniformDensityProperties(model.mesh_O, shape.family->density_kgpm3);
  model.friction = kSampledFriction;
  model.diameter_m = Diameter(model.mesh_O);
  model.mesh_hash = MeshHash(model.mesh_O);
  return model;
}

}  // namespace pickbed::scenes
