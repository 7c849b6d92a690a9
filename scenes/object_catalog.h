#pragma once

// Finds parts by name in folders NAME/{mesh, object.yaml}, or makes one from a mesh file.
//
// object.yaml (the mesh's own frame is O; its vertices are never moved):
//   mesh: mesh.obj           # beside it, any format of mesh_io.h
//   unit: m                  # of the mesh and convex files: m, cm, mm, in
//   mass_kg: 0.12            # or density_kgpm3: 2700
//   com_m: [0, 0, 0]                          # centre of mass and inertia about it, where the mesh
//   inertia_diagonal_kgm2: [1e-4, 1e-4, 1e-4] # cannot say: xx yy zz
//   inertia_products_kgm2: [0, 0, 0]          # xy xz yz (with the tensor's own signs)
//   friction: 0.5            # against a gripper pad, see friction.h
//   convex: convex.obj       # optional convex pieces, one "o" group each
//   symmetries:
//     discrete:              # every one but the identity, as a turn
//       - {axis: [0, 0, 1], angle_deg: 180, offset_m: [0, 0, 0]}
//     continuous:
//       - {axis: [0, 0, 1], offset_m: [0, 0, 0]}
//   resting_poses:           # most frequent first: the world's up in O, share of drops
//     - {up: [0, 0, 1], probability: 0.8}
//
// Inside-out meshes are turned outwards. An open mesh (a scan with a hole) gets the mass properties
// of what it nearly encloses, or of its bounding box where that makes no sense.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scenes/files.h"
#include "scenes/object_model.h"

namespace pickbed {

// How to make a part from a mesh that is in no catalog.
struct MeshPartSpec {
  std::filesystem::path mesh;
  std::string unit = "m";  // m, cm, mm, in
  double mass_kg = 0;      // > 0
  double friction = 0.5;
  SymmetrySet symmetries_O;
};

// Throws InputError when the mesh is missing, has NaN, no faces, no volume, is under 3 mm large, or
// mass is not positive.
std::shared_ptr<const ObjectModel> LoadMeshPart(const std::string& name, const MeshPartSpec& spec);

class ObjectCatalog {
 public:
  // Earlier roots win. The shipped catalog is AssetsDir() / "objects".
  explicit ObjectCatalog(std::vector<std::filesystem::path> roots);

  std::vector<std::string> Names() const;  // sorted

  // Throws InputError for an unknown name, with the nearest known one.
  std::shared_ptr<const ObjectModel> Load(const std::string& name) const;

 private:
  std::vector<std::filesystem::path> roots_;
};

}  // namespace pickbed
