#pragma once

// Exports scenes for 3D viewers: meshes at their poses and colored point clouds as one binary
// glTF 2.0 file, and point clouds as PLY.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "scenes/geometry/pose.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// A mesh at a pose. Colors here are sRGB, 0..1. The file contains linear colors, as glTF
// requires.
struct GlbPart {
  std::string name;
  const TriangleMesh* mesh = nullptr;  // in its own frame, m; not null, at least one triangle
  Pose X_W = Pose::Identity();         // pose of the mesh's frame in the world
  Eigen::Vector4f rgba = Eigen::Vector4f::Ones();  // replaces the mesh's own colors
  // Poses of the animation, one per frame, the first at time 0; empty = at rest at X_W.
  std::vector<Pose> track_W = {};
};

// A colored point cloud.
struct GlbCloud {
  std::string name;
  std::vector<Eigen::Vector3f> points_W;  // m; at least one
  std::vector<Eigen::Vector3f> rgb;       // sRGB, 0..1, one for each point
};

// Returns the bytes of a .glb file. The root node "world" rotates the world's z up to glTF's y up.
// Its children are one node for each part and cloud, in order, with the name and the pose as a
// matrix. Parts with the same mesh and color share the geometry and a material with the name of
// the first. Coordinates are 32-bit floats. The same input gives the same bytes. Throws
// std::logic_error when the scene, a mesh or a cloud is empty or colors are missing.
//
// If a part has a track, the file holds one animation "motion" whose frames are `frame_s` apart. A
// viewer interpolates between them. Names of parts with a track must be unique, else
// std::logic_error is thrown.
std::string GlbBytes(std::span<const GlbPart> glb_parts, std::span<const GlbCloud> clouds,
                     double frame_s = 0.1);

// Returns the bytes of a binary little-endian PLY with x y z (float, m) and red green blue (uchar)
// of each point. `rgb` is sRGB, 0..1, one for each point, else std::logic_error is thrown. The same
// input gives the same bytes.
std::string PlyCloudBytes(std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Vector3f> rgb);

}  // namespace pickbed::scenes
