#pragma once

// From a mesh file to a part with everything that physics and estimators want to know of it.

#include <filesystem>
#include <functional>
#include <string>

#include "scenes/mesh_inspection.h"
#include "scenes/object_files.h"
#include "sim/piece_quality.h"
#include "sim/resting_poses.h"

namespace pickbed {

struct ObjectRequest {
  std::string name;
  std::filesystem::path mesh;
  std::string unit;  // empty = guess
  double density_kgpm3 = 1000;
  double mass_kg = 0;  // > 0: this, whatever the density
  double friction = 0.5;
  double symmetry_tolerance = 0.01;  // share of the diameter
  int drops = 100;                   // for the resting poses
  bool center = false;               // move the origin to the middle
};

struct StageTime {
  std::string stage;
  double seconds = 0;
};

struct MadeObject {
  ObjectRecord record;
  ObjectModel model;  // the same, ready for use
  InspectedMesh inspected;
  PieceQuality quality;
  std::vector<RestingPose> resting;
  bool mass_from_hull = false;  // the mesh is open
  std::vector<StageTime> seconds;
};

// Throws InputError for a mesh that cannot be used, see InspectMeshFile. `on_stage` hears the name
// of each stage as it begins.
MadeObject MakeObject(const ObjectRequest& request,
                      const std::function<void(const std::string&)>& on_stage = {});

}  // namespace pickbed
