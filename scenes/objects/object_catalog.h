#pragma once

// Finds objects by name in folders NAME/{mesh, object.yaml}, or makes an object from a mesh file.
//
// object.yaml (the mesh's own frame is O; its vertices are never moved):
//   mesh: mesh.obj           # in the same folder, any format of mesh_io.h
//   unit: m                  # of the mesh and convex files: m, cm, mm, in
//   mass_kg: 0.12            # or density_kgpm3: 2700
//   com_m: [0, 0, 0]                          # center of mass; used only with the inertia
//   inertia_diagonal_kgm2: [1e-4, 1e-4, 1e-4] # about com_m, xx yy zz; else uniform density
//   inertia_products_kgm2: [0, 0, 0]          # xy xz yz (with the signs of the tensor)
//   friction: 0.5            # against a gripper pad, see contact.h
//   convex: convex.obj       # optional convex pieces, one "o" group each
//   symmetries:
//     discrete:              # all except the identity, as rotations
//       - {axis: [0, 0, 1], angle_deg: 180, offset_m: [0, 0, 0]}
//     continuous:
//       - {axis: [0, 0, 1], offset_m: [0, 0, 0]}
//   resting_poses:           # most frequent first: the world's up in O, share of drops
//     - {up: [0, 0, 1], probability: 0.8}
//
// Inside-out meshes are turned outwards. An open mesh (a scan with a hole) gets the mass properties
// of the volume that it nearly encloses, or of its bounding box if the former are impossible.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scenes/base/files.h"
#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

inline constexpr char kObjectFile[] = "object.yaml";  // in the folder of an object

// Properties of an object that is made from a mesh file without a catalog.
struct MeshObjectSpec {
  std::filesystem::path mesh;
  std::string unit = "m";    // m, cm, mm, in
  double mass_kg = 0;        // > 0, or else
  double density_kgpm3 = 0;  // > 0
  double friction = 0.5;
  SymmetrySet symmetries_O;
};

// Makes an object from a mesh file. Throws InputError when the mesh is missing, has NaN, no faces
// or no volume, the object is smaller than 3 mm, or friction or both mass and density are not
// positive.
std::shared_ptr<const ObjectModel> LoadMeshObject(const std::string& name,
                                                  const MeshObjectSpec& spec);

// Finds and loads objects by name.
class ObjectCatalog {
 public:
  // Searches the folders in `roots`; an earlier one has priority. The shipped catalog is
  // AssetsDir() / "objects".
  explicit ObjectCatalog(std::vector<std::filesystem::path> roots);

  std::vector<std::string> Names() const;  // sorted

  // Loads an object. A name that begins with "sampled/" gives a sampled shape without files, see
  // scenes/shape_families/sampled_names.h. Throws InputError for an unknown name, with the nearest
  // known name.
  std::shared_ptr<const ObjectModel> Load(const std::string& name) const;

 private:
  std::vector<std::filesystem::path> roots_;
};

}  // namespace pickbed::scenes
