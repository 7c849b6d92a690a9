#include "scenes/bin/bin.h"

#include <array>

namespace pickbed::scenes {
namespace {

// Returns the corners of a rectangle at height z, counter-clockwise as seen from above.
std::array<Eigen::Vector3d, 4> Ring(const Eigen::Vector2d& half, double z) {
  return {Eigen::Vector3d(-half.x(), -half.y(), z), Eigen::Vector3d(half.x(), -half.y(), z),
          Eigen::Vector3d(half.x(), half.y(), z), Eigen::Vector3d(-half.x(), half.y(), z)};
}

// Adds eight triangles between two rings. The bands go up the outer wall, across the rim and down
// the inner wall, in one direction around the solid. All of them therefore face outwards.
void AddBand(int from, int to, TriangleMesh& mesh) {
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    mesh.triangles.emplace_back(from + i, from + j, to + j);
    mesh.triangles.emplace_back(from + i, to + j, to + i);
  }
}

}  // namespace

std::vector<AxisAlignedBox> BinBoxes(const Bin& bin) {
  const Eigen::Vector3d inner = 0.5 * bin.inner_size_m;
  const double half_wall = 0.5 * bin.wall_m;
  const Eigen::Vector2d outer = inner.head<2>() + Eigen::Vector2d::Constant(bin.wall_m);
  std::vector<AxisAlignedBox> boxes;
  boxes.push_back({{0, 0, -half_wall}, {outer.x(), outer.y(), half_wall}});
  if (bin.inner_size_m.z() <= 0) return boxes;
  for (const double side : {-1.0, 1.0}) {  // the walls at +-x fit between the walls at +-y
    boxes.push_back(
        {{side * (inner.x() + half_wall), 0, inner.z()}, {half_wall, inner.y(), inner.z()}});
    boxes.push_back(
        {{0, side * (inner.y() + half_wall), inner.z()}, {outer.x(), half_wall, inner.z()}});
  }
  return boxes;
}

bool Bin::Holds(const Eigen::Vector3d& p_B) const {
  const Eigen::Vector2d room_m = shape ? shape->opening_m : Eigen::Vector2d(inner_size_m.head<2>());
  return (p_B.head<2>().cwiseAbs().array() <= 0.5 * room_m.array()).all() && p_B.z() > 0;
}

std::vector<std::vector<Eigen::Vector3d>> BinPieces(const Bin& bin) {
  if (bin.shape) return bin.shape->pieces_B;
  std::vector<std::vector<Eigen::Vector3d>> pieces;
  for (const AxisAlignedBox& box : BinBoxes(bin)) {
    std::vector<Eigen::Vector3d>& corners = pieces.emplace_back();
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      corners.push_back(box.center + sign.cwiseProduct(box.half_size));
    }
  }
  return pieces;
}

TriangleMesh BinMesh(const Bin& bin) {
  if (bin.shape) return bin.shape->mesh_B;
  const Eigen::Vector2d inner = 0.5 * bin.inner_size_m.head<2>();
  const Eigen::Vector2d outer = inner + Eigen::Vector2d::Constant(bin.wall_m);
  const double height = bin.inner_size_m.z();
  TriangleMesh mesh;
  const auto add_ring = [&](const Eigen::Vector2d& half, double z) {
    for (const Eigen::Vector3d& corner : Ring(half, z)) mesh.vertices.push_back(corner);
  };
  add_ring(outer, -bin.wall_m);
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};  // underside
  if (height <= 0) {
    add_ring(outer, 0);
    AddBand(0, 4, mesh);
    mesh.triangles.insert(mesh.triangles.end(), {{4, 5, 6}, {4, 6, 7}});
    return mesh;
  }
  add_ring(outer, height);
  add_ring(inner, height);
  add_ring(inner, 0);
  AddBand(0, 4, mesh);   // outside
  AddBand(4, 8, mesh);   // rim
  AddBand(8, 12, mesh);  // inside
  mesh.triangles.insert(mesh.triangles.end(), {{12, 13, 14}, {12, 14, 15}});
  return mesh;
}

}  // namespace pickbed::scenes
