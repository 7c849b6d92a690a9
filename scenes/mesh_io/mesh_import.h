#pragma once

// Import of a mesh file by assimp. assimp crashes on some damaged files, so LoadMesh()
// (scenes/mesh_io/mesh_io.h) calls it in a process of its own.

#include <filesystem>
#include <set>

#include "scenes/geometry/triangle_mesh.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::scenes {

struct ImportedMesh {
  TriangleMesh mesh;
  MeshLoadReport report;
  // Files beside the mesh that were looked for, such as materials and textures, also missing ones.
  std::set<std::filesystem::path> used;
};

// Loads all meshes of a file as one. Node transforms are applied, and lengths are multiplied by
// `scale`. Throws as LoadMesh().
ImportedMesh ImportMesh(const std::filesystem::path& path, double scale);

}  // namespace pickbed::scenes
