#pragma once

// Scenes for 3D viewers: meshes at their poses and coloured point clouds as one binary glTF 2.0.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "scenes/pose.h"
#include "scenes/triangle_mesh.h"

namespace pickbed {

// Colours are sRGB, 0..1, as in pictures; the file holds them linear, as glTF wants.
struct GlbPart {
  std::string name;
  const TriangleMesh* mesh = nullptr;  // in its own frame, m; not null, one triangle at least
  Pose X_W = Pose::Identity();         // of that frame in the world
  Eigen::Vector4f rgba = Eigen::Vector4f::Ones();  // of all of it: its own colours do not count
};

struct GlbCloud {
  std::string name;
  std::vector<Eigen::Vector3f> points_W;  // m; one at least
  std::vector<Eigen::Vector3f> rgb;       // one a point
};

// The bytes of a .glb file. All hangs below a node "world" that turns the world's z up into glTF's
// y up; below it is a node for each part and cloud, in order, with its name and, as a matrix, its
// pose. Parts of one mesh and colour share their geometry and a material, which has the name of the
// first. Coordinates are 32-bit floats. Same input, same bytes. Throws std::logic_error when there
// is nothing, a mesh or cloud is empty or colours are missing.
std::string GlbBytes(std::span<const GlbPart> parts, std::span<const GlbCloud> clouds);

}  // namespace pickbed
