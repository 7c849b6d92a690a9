#include "sim/drop/object_maker.h"

#include <fmt/format.h>

#include <chrono>

#include "scenes/base/error.h"
#include "scenes/geometry/symmetry_finder.h"
#include "scenes/objects/object_settings.h"
#include "scenes/objects/sampled_object.h"
#include "sim/convex/convex_hull.h"

namespace pickbed::sim {
namespace {

class StageClock {
 public:
  StageClock(const std::function<void(const std::string&)>& on_stage,
             std::vector<MakeStageTime>& seconds)
      : on_stage_(on_stage), seconds_(seconds) {}

  template <typename Work>
  auto Time(const std::string& stage, Work work) {
    using Clock = std::chrono::steady_clock;
    if (on_stage_) on_stage_(stage);
    const auto begin = Clock::now();
    auto result = work();
    seconds_.push_back({stage, std::chrono::duration<double>(Clock::now() - begin).count()});
    return result;
  }

 private:
  const std::function<void(const std::string&)>& on_stage_;
  std::vector<MakeStageTime>& seconds_;
};

TriangleMesh HullOf(const TriangleMesh& mesh) {
  const ConvexHull hull = MakeConvexHull(mesh.vertices);
  TriangleMesh solid;
  solid.vertices = hull.vertices;
  solid.triangles = hull.triangles;
  return solid;
}

MassProperties MassOf(const ObjectRequest& request, const InspectedMesh& inspected) {
  const TriangleMesh solid = inspected.watertight ? inspected.mesh_O : HullOf(inspected.mesh_O);
  if (request.mass_kg > 0) return UniformMassProperties(solid, request.mass_kg);
  return UniformDensityProperties(
      solid, request.density_kgpm3 > 0 ? request.density_kgpm3 : kDefaultDensity_kgpm3);
}

}  // namespace

MadeObject MakeObject(const ObjectRequest& request,
                      const std::function<void(const std::string&)>& on_stage) {
  MadeObject made;
  StageClock clock(on_stage, made.seconds);
  made.inspected = clock.Time("inspect the mesh", [&] {
    return InspectMeshFile(request.mesh, request.unit, request.center);
  });
  const TriangleMesh& mesh_O = made.inspected.mesh_O;
  made.mass_from_hull = !made.inspected.watertight;
  made.mass_by_default_density = request.mass_kg == 0 && request.density_kgpm3 == 0;

  ObjectModel& model = made.model;
  model.name = request.name;
  model.mesh_O = mesh_O;
  model.friction = request.friction;
  model.diameter_m = Diameter(mesh_O);
  model.mesh_hash = MeshHash(mesh_O);
  model.mass = clock.Time("weigh", [&] { return MassOf(request, made.inspected); });
  CheckInput(model.mass.mass_kg <= kMaxObjectMass_kg,
             fmt::format("mesh '{}' would have a mass of {:.4g} kg by its volume and density; an "
                         "object has {:g} kg at most: check the unit, or give the mass",
                         request.mesh.string(), model.mass.mass_kg, kMaxObjectMass_kg));
  FittedPieces fitted =
      clock.Time("cut into convex pieces", [&] { return FitConvexPieces(mesh_O); });
  CheckInput(!fitted.pieces.empty(),
             fmt::format("mesh '{}' is too flat for collisions; give it a thickness",
                         request.mesh.string()));
  made.quality = fitted.quality;
  model.convex_pieces_O = std::move(fitted.pieces);
  model.symmetries_O = clock.Time("find symmetries", [&] {
    return FindSymmetries(mesh_O, {.tolerance_diameters = request.symmetry_tolerance});
  });
  made.resting =
      clock.Time("find resting poses", [&] { return FindRestingPoses(model, request.drops); });
  for (const RestingPose& pose : made.resting) {
    model.resting_O.push_back({pose.up_O, pose.probability});
  }

  ObjectRecord& record = made.record;
  record.help = fmt::format("made from {}", request.mesh.filename().string());
  record.mesh_O = mesh_O;
  record.convex_pieces_O = model.convex_pieces_O;
  record.symmetries_O = model.symmetries_O;
  record.mass = model.mass;
  record.friction = model.friction;
  record.resting_O = model.resting_O;
  return made;
}

ObjectRecord MakeSampledObject(const SampledShape& shape) {
  ObjectRecord record;
  record.help = fmt::format("sampled shape: {}, {}, seed {}", shape.family->name,
                            ShapeSplitName(shape.split), shape.seed);
  for (size_t i = 0; i < shape.values.size(); ++i) {
    record.help += fmt::format("{}{} {:.4g}", i == 0 ? "; " : ", ",
                               shape.family->parameters[i].name, shape.values[i]);
  }
  ObjectModel model = SampledObject(shape.family->name, shape);
  record.mesh_O = std::move(model.mesh_O);
  record.density_kgpm3 = shape.family->density_kgpm3;
  record.friction = model.friction;
  record.convex_pieces_O = FitConvexPieces(record.mesh_O).pieces;
  record.symmetries_O = FindSymmetries(record.mesh_O);
  return record;
}

}  // namespace pickbed::sim
