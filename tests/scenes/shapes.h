#pragma once

// Small meshes whose area, volume and diameter have a closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "scenes/base/error.h"
#include "scenes/geometry/triangle_mesh.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {

// Returns a closed box: 8 vertices, 12 triangles, faces outwards.
inline TriangleMesh BoxShape(const Eigen::Vector3d& size,
                             const Eigen::Vector3d& center = Eigen::Vector3d::Zero()) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d side(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5,
                               corner & 4 ? 0.5 : -0.5);
    mesh.vertices.push_back(center + side.cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// Returns an octahedron whose faces are split `levels` times, with vertices on the sphere and
// smooth normals.
inline TriangleMesh BallShape(double radius, int levels) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> midpoint_of;
    const auto midpoint = [&](int a, int b) {
      const auto [place, is_new] =
          midpoint_of.try_emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return place->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const int ab = midpoint(t[0], t[1]), bc = midpoint(t[1], t[2]), ca = midpoint(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  mesh.normals = mesh.vertices;
  for (Eigen::Vector3d& v : mesh.vertices) v *= radius;
  return mesh;
}

// Returns a 2 x 2 image with a different color in each pixel.
inline Image<Rgb8> FourColors() {
  Image<Rgb8> image(2, 2);
  image(0, 0) = {250, 0, 0};
  image(1, 0) = {0, 250, 0};
  image(0, 1) = {0, 0, 250};
  image(1, 1) = {250, 250, 0};
  return image;
}

inline void TurnInsideOut(TriangleMesh& mesh) {
  for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
}

// Returns the message of the InputError that `call` throws. Fails the test if it throws none.
template <typename Call>
std::string InputErrorOf(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "threw no InputError";
  return "";
}

}  // namespace pickbed::tests
