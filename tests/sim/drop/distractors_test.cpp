#include "sim/drop/distractors.h"

#include <gtest/gtest.h>

#include <set>

#include "scenes/part_families/part_families.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

ObjectSet Sizes(const std::vector<double>& diameters_m) {
  ObjectSet objects;
  for (const double diameter_m : diameters_m) {
    auto model = std::make_shared<ObjectModel>();
    model->diameter_m = diameter_m;
    objects.push_back(model);
  }
  return objects;
}

// True if each edge occurs once in either direction.
bool IsClosed(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> open;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::pair<int, int> edge(t[i], t[(i + 1) % 3]);
      if (open.erase({edge.second, edge.first}) == 0 && !open.insert(edge).second) return false;
    }
  }
  return open.empty();
}

TEST(Distractors, AreClosedShapesWithTheSizeOfTheObjects) {
  DistractorOptions options;
  options.per_object = 30;
  const std::vector<double> diameters_m = {0.02, 0.3};
  const ObjectSet shapes = MakeDistractors(Sizes(diameters_m), options);
  ASSERT_EQ(shapes.size(), 60u);
  for (size_t i = 0; i < shapes.size(); ++i) {
    const double object_m = diameters_m[i / 30];
    EXPECT_NEAR(Diameter(shapes[i]->mesh_O), shapes[i]->diameter_m, 1e-9);
    EXPECT_GE(shapes[i]->diameter_m, options.diameter_min * object_m);
    EXPECT_LE(shapes[i]->diameter_m, options.diameter_max * object_m);
    EXPECT_TRUE(IsClosed(shapes[i]->mesh_O)) << i;
    EXPECT_GT(shapes[i]->mass.mass_kg, 0);
  }
}

TEST(Distractors, DifferFromEachOtherAndRepeat) {
  const ObjectSet shapes = MakeDistractors(Sizes({0.1, 0.1}));
  const ObjectSet again = MakeDistractors(Sizes({0.1, 0.1}));
  std::set<uint64_t> hashes;
  for (size_t i = 0; i < shapes.size(); ++i) {
    hashes.insert(shapes[i]->mesh_hash);
    EXPECT_EQ(shapes[i]->mesh_hash, again[i]->mesh_hash);
  }
  EXPECT_EQ(hashes.size(), shapes.size() / 2) << "equal sizes give equal shapes";
}

}  // namespace
}  // namespace pickbed::tests
