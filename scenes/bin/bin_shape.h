#pragma once

// A bin of any shape, made from a mesh: its inner dimensions and its convex pieces for collisions.

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Frame B is defined in scenes/bin/bin.h: z = 0 is the floor, the origin is in its center.
struct BinShape {
  TriangleMesh mesh_B;  // closed, faces outwards
  // Vertices of the convex solids that represent the bin in physics. The front of each is exactly a
  // flat region of the surface. Its depth is the local thickness of the solid, 50 mm at most. A
  // floor is extended downwards to 50 mm, so that nothing falls through a thin sheet.
  std::vector<std::vector<Eigen::Vector3d>> pieces_B;
  // x, y: inner size at the narrowest height; z: height of the rim.
  Eigen::Vector3d inner_size_m = Eigen::Vector3d::Zero();
  // Inner size at the widest height below the rim, symmetric about the origin.
  Eigen::Vector2d opening_m = Eigen::Vector2d::Zero();
  double wall_m = 0;  // largest distance from inner_size_m to the outside, x or y
};

// Measures `mesh` (m) and moves it into frame B. The mesh must be upright (z up, opening upwards),
// at any place.
//
// The shape is measured with vertical rays. The floor is the median height of the hits over the
// central half of the mesh. The width is measured along five lines in x and five in y, spread over
// the central half. The inside is narrowest where the ground is at most 1/20 of the wall height (at
// least 1 mm) above the floor, so that rounded edges and compartments count as inside. It is widest
// where the ground is below the rim, which is the mesh's highest point.
//
// Throws InputError, naming `source`, when the mesh is open, has no floor, opens downwards, has
// more than 50,000 faces or an inner size outside 0.01 to 10 m.
BinShape MakeBinShape(const TriangleMesh& mesh, const std::string& source);

// Same for a mesh file; `unit` as in mesh_io.h.
BinShape LoadBinShape(const std::filesystem::path& file, const std::string& unit);

}  // namespace pickbed::scenes
