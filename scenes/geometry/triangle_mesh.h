#pragma once

// An indexed triangle mesh in metres, with measures and transformations of it. Triangles are
// counter-clockwise as seen from outside.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scenes/base/random.h"
#include "scenes/geometry/pose.h"
#include "scenes/image/image.h"

namespace pickbed::scenes {

// Vertices, triangles and optional attributes per vertex.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  // m
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Eigen::Vector3d> normals;  // per vertex, unit; empty = flat shading by faces
  std::vector<Eigen::Vector2d> uvs;      // per vertex; empty = no texture; v = 0 is the top row
  std::vector<Rgb8> colors;              // per vertex; empty = base_color
  Rgb8 base_color{176, 176, 180};
  Image<Rgb8> texture;  // empty = none
};

// Axis-aligned bounding box, m.
struct Bounds {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  Eigen::Vector3d size() const { return max - min; }
  Eigen::Vector3d center() const { return 0.5 * (min + max); }
  // Returns the eight corners as columns; x changes fastest, then y, then z.
  Eigen::Matrix<double, 3, 8> Corners() const;
};

// Returns the axis-aligned box around the vertices, in the frame of the mesh (m). The box of a mesh
// without vertices is a point at zero.
Bounds MeshBounds(const TriangleMesh& mesh);

// Returns the exact largest distance between two vertices, in m. It is BOP's object diameter.
double Diameter(const TriangleMesh& mesh);

// In m^2.
double SurfaceArea(const TriangleMesh& mesh);

// Returns the unit normal of each triangle (zero for a degenerate triangle).
std::vector<Eigen::Vector3d> FaceNormals(const TriangleMesh& mesh);

// Returns the mesh, given in frame B, expressed in frame A.
TriangleMesh Transformed(const TriangleMesh& mesh_B, const Pose& X_AB);
TriangleMesh Scaled(const TriangleMesh& mesh, double factor);  // factor > 0

// Appends `other` (not the same object as `mesh`). Normals are kept if both meshes have them, and
// uvs if both have the same texture. Base colors become vertex colors if they differ.
void Append(const TriangleMesh& other, TriangleMesh& mesh);

// Points on a surface, in the mesh's frame.
struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points;   // m
  std::vector<Eigen::Vector3d> normals;  // unit, of the face
  std::vector<int> triangles;            // index of the face
};
// Draws `count` samples uniformly over the surface. Throws InputError when the mesh has no area.
SurfaceSamples SampleSurface(const TriangleMesh& mesh, int count, Rng& rng);

// Returns a hash of the vertex and triangle bytes, without color. It is the key of every cache and
// model file.
uint64_t MeshHash(const TriangleMesh& mesh);

}  // namespace pickbed::scenes
