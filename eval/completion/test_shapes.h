#pragma once

// Solids for tests of shape completion: sampled shapes of each split, and meshes.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "perception/completion/viewed_solid.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::eval {

// A solid that is given by a mesh, which need not be closed. Its inside is computed once on a grid:
// a point is inside if the lines along at least two of the three axes cross the surface an odd
// number of times before it.
class MeshSolid : public ViewedSolid {
 public:
  explicit MeshSolid(const TriangleMesh& mesh_O, int grid_cells = 128);
  ~MeshSolid() override;
  Image<float> Depth(const CameraIntrinsics& intrinsics, const Pose& X_CO) const override;
  void Inside(std::span<const Eigen::Vector3f> points_O, std::span<uint8_t> inside) const override;
  float LowestAlong(const Eigen::Vector3f& normal_O) const override;
  Eigen::AlignedBox3f box_O() const override { return box_O_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  Eigen::AlignedBox3f box_O_;
  int cells_[3];
  float cell_m_;
  std::vector<uint8_t> grid_;  // x fastest, 1 = the center of the cell is inside
};

struct TestShape {
  std::string set;  // a name of TestSetNames()
  std::string name;
  std::shared_ptr<const ViewedSolid> solid;
};

// Returns the names of all sets: seen, unseen_sizes, outside, unseen_families, catalog, ycb and
// industrial. The last two are folders of meshes in the folder of test data.
std::vector<std::string> TestSetNames();

// Makes the solids of a set: `count` of each shape family, or all objects or meshes. The result is
// empty if `data_folder` does not have the set's meshes.
std::vector<TestShape> TestShapesOf(const std::string& set, int count,
                                    const std::filesystem::path& data_folder);

}  // namespace pickbed::eval
