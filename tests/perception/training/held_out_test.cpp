#include "perception/training/held_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/voting/pose_clustering.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

constexpr double kSide_m = 0.064;

HeldOutOptions Few() {
  HeldOutOptions options;
  options.clutter_scenes = 2;
  options.queries = 25;
  options.book_views = 10;
  return options;
}

const auto kGoOn = [](double) { return true; };

class HeldOut : public testing::Test {
 protected:
  RayCastViews views_{{ObjectOf(BracketMesh())}};
};

TEST_F(HeldOut, EveryQueryHasARightAnswerInTheCodebook) {
  const HeldOutSet set = MakeHeldOut(views_, {{kSide_m}}, Few(), 5, kGoOn);
  ASSERT_EQ(set.queries.size(), 1u);
  ASSERT_EQ(set.queries[0].size(), 25u);
  EXPECT_EQ(set.distract[0].size(), 40u);
  const PoseDistance distance(*views_.objects()[0]);
  for (size_t i = 0; i < 25; ++i) {
    EXPECT_LT(distance(set.queries[0].anchors.X_PO[i], set.queries[0].codes.X_PO[i]), 0.1);
  }
}

TEST_F(HeldOut, SeedDeterminesTheSet) {
  const HeldOutSet a = MakeHeldOut(views_, {{kSide_m}}, Few(), 5, kGoOn);
  const HeldOutSet b = MakeHeldOut(views_, {{kSide_m}}, Few(), 5, kGoOn);
  const HeldOutSet c = MakeHeldOut(views_, {{kSide_m}}, Few(), 6, kGoOn);
  EXPECT_EQ(a.queries[0].anchors.values, b.queries[0].anchors.values);
  EXPECT_EQ(a.distract[0].values, b.distract[0].values);
  EXPECT_NE(a.queries[0].anchors.values, c.queries[0].anchors.values);
}

TEST_F(HeldOut, StopRequestEndsTheWork) {
  int calls = 0;
  MakeHeldOut(views_, {{kSide_m}}, Few(), 5, [&](double) {
    ++calls;
    return false;
  });
  EXPECT_EQ(calls, 1);
  // The third call comes while the isolated views are rendered.
  calls = 0;
  const HeldOutSet set =
      MakeHeldOut(views_, {{kSide_m}}, Few(), 5, [&](double) { return ++calls < 3; });
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(set.queries[0].size(), 0u);
}

// Three queries at poses far apart. The descriptor of a patch is its first byte.
HeldOutSet ThreePoses() {
  HeldOutSet set;
  set.queries.resize(1);
  set.distract.resize(1);
  for (int i = 0; i < 3; ++i) {
    const Pose X_PO = Translation({0.3 * i, 0, 0});
    for (LabelledPatches* patches : {&set.queries[0].anchors, &set.queries[0].codes}) {
      patches->X_PO.push_back(X_PO);
      patches->values.insert(patches->values.end(), kPatchValues, static_cast<int8_t>(20 * i));
    }
  }
  return set;
}

std::vector<float> FirstByte(std::span<const int8_t> patches) {
  std::vector<float> rows;
  for (size_t i = 0; i < patches.size(); i += kPatchValues) rows.push_back(patches[i]);
  return rows;
}

TEST_F(HeldOut, RecallCountsRightAnswersAmongTheNearest) {
  HeldOutSet set = ThreePoses();
  HeldOutRecall recall = MeasureRecall(set, views_.objects(), FirstByte, 1);
  EXPECT_DOUBLE_EQ(recall.at_1, 1);
  EXPECT_DOUBLE_EQ(recall.at_8, 1);

  // The first query looks like the second pose: its first answer is wrong, and its own pose is
  // among the eight.
  set.queries[0].anchors.values[0] = 20;
  recall = MeasureRecall(set, views_.objects(), FirstByte, 1);
  EXPECT_DOUBLE_EQ(recall.at_1, 2.0 / 3);
  EXPECT_DOUBLE_EQ(recall.at_8, 1);
  const auto answers = AnswersOf(set, views_.objects(), FirstByte, 1, 10);
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_FALSE(answers[0].right);
  EXPECT_EQ(answers[0].found[1], 20);
  EXPECT_TRUE(answers[1].right);

  // Eight more similar patches at a wrong pose displace its own.
  for (int i = 0; i < 8; ++i) {
    set.distract[0].X_PO.push_back(Translation({9, 0, 0}));
    set.distract[0].values.insert(set.distract[0].values.end(), kPatchValues, 19);
  }
  recall = MeasureRecall(set, views_.objects(), FirstByte, 1);
  EXPECT_DOUBLE_EQ(recall.at_1, 1.0 / 3 + 1.0 / 3);
  EXPECT_DOUBLE_EQ(recall.at_8, 2.0 / 3);
}

TEST_F(HeldOut, SamePoseOfAnotherObjectIsWrong) {
  HeldOutSet set = ThreePoses();
  set.queries.resize(2);
  set.distract.resize(2);
  set.distract[1] = set.queries[0].codes;
  set.queries[0].codes = {};
  const ObjectSet two{views_.objects()[0], views_.objects()[0]};
  const HeldOutRecall recall = MeasureRecall(set, two, FirstByte, 1);
  EXPECT_DOUBLE_EQ(recall.object_at_8[0], 0);
  EXPECT_DOUBLE_EQ(recall.object_at_1[1], -1) << "an object without queries has no recall";
}

TEST_F(HeldOut, ViewDirectionPointsAtTheCamera) {
  HeldOutSet set = ThreePoses();
  // The object is rotated by 90 degrees about x: the camera, at -z of the patch, is at -y of the
  // object.
  for (Pose& X_PO : set.queries[0].anchors.X_PO) {
    X_PO.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  }
  const auto answers = AnswersOf(set, views_.objects(), FirstByte, 1, 1);
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_NEAR((answers[0].view_O - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace pickbed::tests
