#include "eval/benchmark/rooms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/train/job.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

RoomsRow RowOf(const std::vector<RoomsRow>& rows, const std::string& rooms,
               const std::string& background) {
  for (const RoomsRow& row : rows) {
    if (row.rooms == rooms && row.background == background) return row;
  }
  ADD_FAILURE() << rooms << " " << background << " is absent";
  return {};
}

// The same image is estimated without and with the given bin.
TEST(RunRooms, CountsImagesInstancesAndPoses) {
  RayCastViews views({ObjectOf(BracketMesh())});
  EstimatorSpec spec;
  spec.name = "ppf";
  spec.mode = "fast";
  spec.min_score = 0.3;
  RoomsOptions options;
  options.bins = 1;
  options.tables = 0;
  options.empty = 0;
  int calls = 0;
  const std::vector<RoomsRow> rows = RunRooms(views, spec, options, [&](int done, int total) {
    EXPECT_EQ(done, calls++);
    EXPECT_EQ(total, 1);
    return true;
  });
  const RoomsRow bin = RowOf(rows, "bin", "all"), given = RowOf(rows, "bin", "given");
  EXPECT_EQ(bin.images, 1);
  EXPECT_GT(bin.instances, 0);
  EXPECT_EQ(given.instances, bin.instances);
  EXPECT_LE(bin.recalled, bin.instances);
  EXPECT_LE(bin.right, bin.poses);
  const RoomsRow all = RowOf(rows, "all", "given");
  EXPECT_EQ(all.images, 1);
  EXPECT_EQ(all.poses, given.poses);
  EXPECT_TRUE(RunRooms(views, spec, options, [](int, int) { return false; }).empty());
}

// Walls, tables and boxes look like hidden mugs to a verifier that has seen only bins: it reports
// 17 poses in 6 such rooms.
TEST(RunRooms, ShippedVerifiersReportNothingInEmptyRooms) {
  TrainingSetChoice choice;
  choice.objects = {"mug"};
  EstimatorSpec spec;
  spec.mode = "fast";
  RoomsOptions options;
  options.bins = options.tables = 0;
  options.empty = 4;
  const auto views = MakeTrainingViews(PlanTrainingSet(choice));
  const std::vector<RoomsRow> rows = RunRooms(*views, spec, options, [](int, int) { return true; });
  EXPECT_EQ(RowOf(rows, "empty", "all").images, 4);
  EXPECT_LE(RowOf(rows, "empty", "all").poses, 1);
}

TEST(RoomsText, ShowsRates) {
  RoomsRow row{"bin", "all"};
  row.images = 4;
  row.instances = 8;
  row.recalled = 6;
  row.poses = 10;
  row.right = 5;
  row.calibration_error = 0.0625;
  const std::string text = RoomsText({row});
  EXPECT_THAT(text, HasSubstr("0.750"));  // recall
  EXPECT_THAT(text, HasSubstr("0.500"));  // precision
  EXPECT_THAT(text, HasSubstr("1.250"));  // false poses per image
  EXPECT_THAT(RoomsCsv({row}), HasSubstr("bin,all,4,8,6,10,5,0.0625,0.0000\n"));
}

}  // namespace
}  // namespace pickbed::tests
