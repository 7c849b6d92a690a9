#pragma once

// A bin of any shape, from a mesh: what it measures inside, and the solid pieces that parts collide
// with.

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

// Frame B is that of scenes/bin.h: z = 0 is the floor, the origin is in its middle.
struct BinShape {
  TriangleMesh mesh_B;  // closed, faces outwards
  // Corners of convex solids that stand for it in physics. Each has a flat region of the surface as
  // its front, exactly, and the solid behind it as far as it is thick there, 50 mm at most; a floor
  // is grown downward to 50 mm, so that nothing falls through a sheet.
  std::vector<std::vector<Eigen::Vector3d>> pieces_B;
  Eigen::Vector3d inner_size_m = Eigen::Vector3d::Zero();  // where it is narrowest, up to the rim
  Eigen::Vector2d opening_m = Eigen::Vector2d::Zero();     // where it is widest, under the rim
  double wall_m = 0;  // from inner_size_m to its outermost point
};

// `mesh` stands upright (z up, opening upward), anywhere; it is moved so that its floor is where
// frame B wants it. Measured by rays straight down, along five lines in x and five in y over the
// middle half: the floor is the median height of what they hit; the inside is narrowest where the
// ground lies within a twentieth of the walls' height (1 mm at least) over the floor, so that
// rounded edges and compartments count as inside, and widest where it lies below the rim. The rim
// is the mesh's highest point. Throws InputError, naming `source`, when the mesh is open, has no
// floor, opens downwards or has more than 50,000 faces.
BinShape MakeBinShape(const TriangleMesh& mesh, const std::string& source);

// The same from a file; `unit` as in mesh_io.h.
BinShape LoadBinShape(const std::filesystem::path& file, const std::string& unit);

}  // namespace pickbed
