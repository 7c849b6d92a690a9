#pragma once

// Makes an object with all its physical and geometric properties from a mesh file.

#include <filesystem>
#include <functional>
#include <string>

#include "scenes/mesh_io/mesh_inspection.h"
#include "scenes/objects/object_writer.h"
#include "scenes/shape_families/shape_family.h"
#include "sim/convex/piece_quality.h"
#include "sim/drop/resting_poses.h"

namespace pickbed::sim {

// Density of an object whose mass and density are not given: plastic has about this density.
inline constexpr double kDefaultDensity_kgpm3 = 1000;

// Input of MakeObject().
struct ObjectRequest {
  std::string name;
  std::filesystem::path mesh;
  std::string unit;          // empty = guess
  double density_kgpm3 = 0;  // 0 = kDefaultDensity_kgpm3
  double mass_kg = 0;        // > 0 replaces the density
  double friction = 0.5;
  double symmetry_tolerance = 0.01;  // share of the diameter
  int drops = 100;                   // simulated drops for the resting poses
  bool center = false;               // true = move the origin to the mesh's center
};

struct MakeStageTime {
  std::string stage;
  double seconds = 0;
};

// A new object, with the intermediate results for its report.
struct MadeObject {
  ObjectRecord record;
  ObjectModel model;  // same content as `record`, ready for use
  InspectedMesh inspected;
  PieceQuality quality;
  std::vector<RestingPose> resting;
  bool mass_from_hull = false;  // true if the mesh is open
  bool mass_by_default_density = false;
  std::vector<MakeStageTime> seconds;
};

// Inspects the mesh, computes mass, convex pieces and symmetries, and drops the object to find its
// resting poses. `on_stage` receives the name of each stage as it begins. Throws InputError for an
// unusable mesh, see InspectMeshFile().
MadeObject MakeObject(const ObjectRequest& request,
                      const std::function<void(const std::string&)>& on_stage = {});

// Makes the object of a sampled shape: mesh, density, friction, color, convex pieces and
// symmetries. Its resting poses are left out; they are found when a scenario needs them.
ObjectRecord MakeSampledObject(const SampledShape& shape);

}  // namespace pickbed::sim
