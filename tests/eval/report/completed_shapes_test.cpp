#include "eval/report/completed_shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/report/run_page.h"
#include "eval/report/views_3d.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

ScenarioSpec SkirtScenario() {
  ScenarioSpec spec = CubeScenario(2);
  spec.planner.name = "skirt";
  return spec;
}

TEST(CompletedShapes, AreThoseOfThePlannerAtTheTrueObjects) {
  const ScenarioSpec spec = SkirtScenario();
  SimulatedCell cell(spec, {Cube(0.05, 0.05, 0.6)});
  const Scene scene = cell.MakeScene(BinIndex(0)).scene;
  const Observation view = cell.Capture(scene, BinIndex(0), 0);
  const CompletedShapes shapes(spec);
  ASSERT_TRUE(shapes.has_any());
  const std::vector<OccupancyShape> found = shapes.Of(cell, scene, cell.objects(), view);
  ASSERT_FALSE(found.empty());
  EXPECT_LE(found[0].size, CompletedShapes::kShownCells);
  // The middle of the skirt is within a side of the middle of a cube.
  Eigen::Vector3d sum_W = Eigen::Vector3d::Zero();
  double weight = 0;
  const OccupancyShape& shape = found[0];
  for (int z = 0; z < shape.size; ++z) {
    for (int y = 0; y < shape.size; ++y) {
      for (int x = 0; x < shape.size; ++x) {
        sum_W += shape.At(x, y, z) * (shape.X_WV * shape.Center_V(x, y, z));
        weight += shape.At(x, y, z);
      }
    }
  }
  double nearest_m = 1;
  for (const PosedObject& posed : scene.objects) {
    nearest_m = std::min(nearest_m, (sum_W / weight - posed.X_WO.translation()).norm());
  }
  EXPECT_LT(nearest_m, 0.05);
  EXPECT_FALSE(CompletedShapes(CubeScenario(1)).has_any());
}

TEST(ExplainUnknown, WritesSegmentsShapesAndAViewWithTheirLayers) {
  const TemporaryFolder folder;
  const ExplanationPage page =
      ExplainUnknown(SkirtScenario(), {Cube(0.05, 0.05, 0.6)}, "cubes", BinIndex(0), folder.path());
  const std::filesystem::path pictures = folder.path() / "pictures" / "trial_0";
  EXPECT_TRUE(std::filesystem::exists(pictures / "segments.png"));
  EXPECT_TRUE(std::filesystem::exists(pictures / "shape_00.png"));
  if (!page.unwritten.empty()) return;  // built without the page template
  const std::string html = ReadFileBytes(page.file);
  EXPECT_THAT(html, HasSubstr("value=\"completed\""));
  EXPECT_THAT(html, HasSubstr("value=\"possible\""));
}

TEST(ExplainUnknown, RefusesAPlannerOnPoses) {
  const TemporaryFolder folder;
  const std::string error = ErrorOf([&] {
    const auto page = ExplainUnknown(CubeScenario(1), EasyCube(), "", BinIndex(0), folder.path());
  });
  EXPECT_THAT(error, HasSubstr("completes no shapes"));
}

// A skirt is thin along the view, so the middle slice of the cube around it is empty.
TEST(ExplainUnknown, ThePictureOfAThinShapeShowsIt) {
  const TemporaryFolder folder;
  const ExplanationPage page =
      ExplainUnknown(SkirtScenario(), {Cube(0.05, 0.05, 0.6)}, "cubes", BinIndex(0), folder.path());
  const Image<Rgb8> picture = ReadPng(folder.path() / "pictures" / "trial_0" / "shape_00.png");
  const int side = picture.height();  // of the slice across the view, on the left
  int dark = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) dark += picture(x, y).r < 128;
  }
  EXPECT_GT(dark, side * side / 10);
}

TEST(ViewHtml, HasASwitchForEstimatedPosesOnlyIfThereAreSome) {
  EXPECT_THAT(ViewHtml({"a", "b", "{\"name\":\"truth 1\"}"}), Not(HasSubstr("hypothesis")));
  EXPECT_THAT(ViewHtml({"a", "b", "{\"name\":\"hypothesis 1\"}"}),
              HasSubstr("value=\"hypothesis\""));
}

TEST(ViewHtml, HasASwitchForCompletedSegmentsOnlyIfThereAreSome) {
  EXPECT_THAT(ViewHtml({"a", "b", "{\"name\":\"truth 1\"}"}), Not(HasSubstr("completed")));
  EXPECT_THAT(ViewHtml({"a", "b", "{\"name\":\"completed 1\"}"}), HasSubstr("value=\"completed\""));
}

}  // namespace
}  // namespace pickbed::tests
