#include "eval/metrics/pose_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "eval/metrics/metric_table.h"
#include "eval/metrics/vertex_tree.h"
#include "scenes/base/random.h"
#include "scenes/mesh_io/mesh_io.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// The eight corners of a box.
MetricModel BoxModel(const Eigen::Vector3d& half) {
  MetricModel model;
  for (int i = 0; i < 8; ++i) {
    model.vertices_O.emplace_back((i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(),
                                  (i & 4 ? 1 : -1) * half.z());
  }
  model.symmetries_O = {Pose::Identity()};
  model.diameter_m = 2 * half.norm();
  return model;
}

Pose RandomPose(Rng& rng) {
  return MakePose(rng.Rotation().toRotationMatrix(),
                  {rng.Uniform(-0.2, 0.2), rng.Uniform(-0.2, 0.2), rng.Uniform(0.6, 1.0)});
}

const CameraIntrinsics kCamera{640, 480, 600, 600, 319.5, 239.5};

TEST(Metrics, GroundTruthHasZeroErrorInEveryMetric) {
  const MetricModel model = BoxModel({0.03, 0.02, 0.01});
  Rng rng(0);
  for (int i = 0; i < 20; ++i) {
    const Pose X = RandomPose(rng);
    for (const MetricRow& row : MetricTable()) {
      if (row.name == std::string_view(kPickRiskMetric))
        continue;  // a pick at the true pose may fail, too
      EXPECT_NEAR(row.compute({model, kCamera, X, X}), 0, 1e-6) << row.name;
    }
  }
}

TEST(Metrics, ShiftIsTheErrorOfEveryDistanceMetric) {
  const MetricModel model = BoxModel({0.03, 0.02, 0.01});
  Rng rng(1);
  const Pose X = RandomPose(rng);
  const Eigen::Vector3d shift(0.003, -0.004, 0.012);
  const Pose moved = Translation(shift) * X;
  EXPECT_NEAR(Mssd(model, moved, X), shift.norm(), 1e-12);
  EXPECT_NEAR(Add(model, moved, X), shift.norm(), 1e-12);
  EXPECT_NEAR(TranslationError(model, moved, X), shift.norm(), 1e-12);
  EXPECT_NEAR(RotationError(model, moved, X), 0, 1e-6);
  EXPECT_LE(Adi(model, moved, X), shift.norm() + 1e-12);
}

TEST(Metrics, RotationMovesCornersByTheChord) {
  const MetricModel model = BoxModel({0.03, 0.04, 0.01});
  const double angle = 0.3;
  const Pose X = Translation({0, 0, 0.8});
  const Pose rotated = X * Pose(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
  const double chord = 2 * 0.05 * std::sin(angle / 2);
  EXPECT_NEAR(Mssd(model, rotated, X), chord, 1e-12);
  EXPECT_NEAR(Add(model, rotated, X), chord, 1e-12);
  EXPECT_NEAR(RotationError(model, rotated, X), angle, 1e-7);
}

TEST(Metrics, MspdOfALateralShiftIsItsProjection) {
  const MetricModel model = BoxModel({0.03, 0.02, 0.0});
  const Pose X = Translation({0, 0, 0.5});
  EXPECT_NEAR(Mspd(model, kCamera, Translation({0.01, 0, 0}) * X, X), 600 * 0.01 / 0.5, 1e-9);
}

TEST(Metrics, SymmetricRotationsHaveZeroError) {
  MetricModel model = BoxModel({0.03, 0.02, 0.01});
  const Pose half_turn(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  Rng rng(2);
  const Pose X = RandomPose(rng);
  EXPECT_GT(Mssd(model, X * half_turn, X), 0.05);
  model.symmetries_O.push_back(half_turn);
  EXPECT_NEAR(Mssd(model, X * half_turn, X), 0, 1e-9);
  EXPECT_NEAR(Mspd(model, kCamera, X * half_turn, X), 0, 1e-6);
  EXPECT_NEAR(RotationError(model, X * half_turn, X), 0, 1e-6);
  EXPECT_GT(Add(model, X * half_turn, X), 0.03);  // ADD ignores symmetries
  EXPECT_NEAR(Adi(model, X * half_turn, X), 0, 1e-9);
}

TEST(VertexTree, FindsTheNearestPoint) {
  Rng rng(8);
  std::vector<Eigen::Vector3d> points, queries;
  for (int i = 0; i < 500; ++i) points.push_back(0.1 * rng.Uniform(0, 1) * rng.UnitVector());
  for (int i = 0; i < 50; ++i) queries.push_back(0.2 * rng.UnitVector());
  queries.push_back(points[7]);
  const std::vector<double> distances_m = VertexTree(points).NearestDistances_m(queries);
  ASSERT_EQ(distances_m.size(), queries.size());
  for (size_t i = 0; i < queries.size(); ++i) {
    double nearest_m = 1;
    for (const auto& p : points) nearest_m = std::min(nearest_m, (p - queries[i]).norm());
    EXPECT_NEAR(distances_m[i], nearest_m, 1e-12) << i;
  }
  EXPECT_TRUE(VertexTree(points).NearestDistances_m({}).empty());
}

TEST(Metrics, AdiEqualsBruteForce) {
  MetricModel model = BoxModel({0.03, 0.02, 0.01});
  Rng rng(3);
  for (int i = 0; i < 300; ++i) model.vertices_O.push_back(0.03 * rng.UnitVector());
  for (int i = 0; i < 5; ++i) {
    const Pose X_est = RandomPose(rng), X_true = RandomPose(rng);
    double sum = 0;
    for (const auto& v : model.vertices_O) {
      double nearest = 1e9;
      for (const auto& w : model.vertices_O) {
        nearest = std::min(nearest, (X_true * v - X_est * w).norm());
      }
      sum += nearest;
    }
    EXPECT_NEAR(Adi(model, X_est, X_true), sum / model.vertices_O.size(), 1e-12);
  }
}

TEST(MakeMetricModel, ReducedVerticesKeepTheMssd) {
  ObjectModel object;
  Rng rng(4);
  for (int i = 0; i < 20000; ++i) object.mesh_O.vertices.push_back(0.05 * rng.UnitVector());
  object.diameter_m = 0.1;
  const MetricModel all = MakeMetricModel(object, 0), few = MakeMetricModel(object, 1000);
  EXPECT_EQ(all.vertices_O.size(), 20000u);
  EXPECT_LE(few.vertices_O.size(), 1000u);
  for (int i = 0; i < 10; ++i) {
    const Pose A = RandomPose(rng), B = RandomPose(rng);
    EXPECT_NEAR(Mssd(few, A, B), Mssd(all, A, B), 0.01 * object.diameter_m);
  }
}

// One of 160 real estimates of one object, with the errors that the BOP toolkit computes.
struct ReferenceRow {
  Pose X_est, X_true;
  std::array<double, 6> errors;  // add, adi, mssd, mspd, re (deg), te; mm and px
};

Pose ParsePose(const std::string& rotation, const std::string& translation) {
  Pose X = Pose::Identity();
  std::istringstream r(rotation), t(translation);
  for (int i = 0; i < 9; ++i) r >> X.matrix()(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) t >> X.matrix()(i, 3);
  return X;
}

std::vector<ReferenceRow> ReadReference(const std::filesystem::path& file) {
  std::vector<ReferenceRow> rows;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    ReferenceRow row{ParsePose(cells[5], cells[6]), ParsePose(cells[3], cells[4]), {}};
    for (int i = 0; i < 6; ++i) row.errors[i] = std::stod(cells[7 + i]);
    rows.push_back(row);
  }
  return rows;
}

TEST(Metrics, EqualTheBopToolkitReference) {
  const std::filesystem::path folder =
      std::filesystem::path(PICKBED_TEST_DATA) / "metrics_reference";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no reference data in " << folder;
  // The file is in millimetres. Read as metres, it gives errors in millimetres.
  ObjectModel object;
  object.mesh_O = LoadMesh(folder / "ape_mm_centred.ply", "m");
  const MetricModel model = MakeMetricModel(object, 0);
  const CameraIntrinsics camera{640, 480, 572.4114, 573.57043, 325.2611, 242.04899};
  const auto rows = ReadReference(folder / "lmo_ape_pose_errors.csv");
  ASSERT_EQ(rows.size(), 160u);
  for (const ReferenceRow& row : rows) {
    const std::array<double, 6> ours{
        Add(model, row.X_est, row.X_true),
        Adi(model, row.X_est, row.X_true),
        Mssd(model, row.X_est, row.X_true),
        Mspd(model, camera, row.X_est, row.X_true),
        RotationError(model, row.X_est, row.X_true) * 180 / std::numbers::pi,
        TranslationError(model, row.X_est, row.X_true)};
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(ours[i], row.errors[i], std::max(1e-3, 1e-5 * row.errors[i])) << "column " << i;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
