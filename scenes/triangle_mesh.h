#pragma once

// An indexed triangle mesh in metres, counter-clockwise from outside.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scenes/image.h"
#include "scenes/pose.h"
#include "scenes/random.h"

namespace pickbed {

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  // m
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Eigen::Vector3d> normals;  // per vertex, unit; empty = flat faces
  std::vector<Eigen::Vector2d> uvs;      // per vertex; empty = no texture; v = 0 is the top row
  std::vector<Rgb8> colors;              // per vertex; empty = base_color
  Rgb8 base_color{176, 176, 180};
  Image<Rgb8> texture;  // empty = none
};

struct Bounds {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  Eigen::Vector3d size() const { return max - min; }
  Eigen::Vector3d center() const { return 0.5 * (min + max); }
  // x changes first.
  Eigen::Matrix<double, 3, 8> Corners() const;
};

Bounds MeshBounds(const TriangleMesh& mesh);

// Largest distance between two vertices: BOP's object diameter. Exact.
double Diameter(const TriangleMesh& mesh);

double SurfaceArea(const TriangleMesh& mesh);

// Unit normal of each triangle (zero for a degenerate one).
std::vector<Eigen::Vector3d> FaceNormals(const TriangleMesh& mesh);

// The mesh, given in frame B, in frame A.
TriangleMesh Transformed(const TriangleMesh& mesh_B, const Pose& X_AB);
TriangleMesh Scaled(const TriangleMesh& mesh, double factor);  // factor > 0

// Appends `other`, which is another mesh: vertices, triangles, normals when both have them, uvs
// when both have the same texture, and colours (base colours become vertex colours where they
// differ).
void Append(const TriangleMesh& other, TriangleMesh& mesh);

// Uniform samples of the surface with their face normals, in the mesh's frame. Throws InputError
// when the mesh has no area.
struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;
  std::vector<int> triangles;
};
SurfaceSamples SampleSurface(const TriangleMesh& mesh, int count, Rng& rng);

// Hash of vertex and triangle bytes (not of colour): the key of every cache and model file.
uint64_t MeshHash(const TriangleMesh& mesh);

}  // namespace pickbed
