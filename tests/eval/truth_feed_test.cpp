#include "eval/truth_feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace pickbed {
namespace {

using ::testing::HasSubstr;

// Two kinds of tripod with 4 cm legs: parts 0 and 1 of kind 0, part 2 of kind 1, far apart.
class TruthFeed : public ::testing::Test {
 protected:
  TruthFeed() {
    MetricModel tripod;
    tripod.vertices_O = {{0.04, 0, 0}, {0, 0.04, 0}, {0, 0, 0.04}};
    tripod.symmetries_O = {Pose::Identity()};
    tripod.diameter_m = 0.0566;
    models_ = {tripod, tripod};
    parts_ = {{0, At(0), 0.9}, {0, At(0.5), 0.6}, {1, At(1), 0.2}};
  }
  static Pose At(double x_m, double y_m = 0) { return Translation({x_m, y_m, 1}); }
  static PoseHypothesis Believe(int object, const Pose& X_CO, double score) {
    PoseHypothesis h;
    h.object = object;
    h.X_CO = X_CO;
    h.score = score;
    return h;
  }
  std::vector<PoseHypothesis> Fed(const std::vector<PoseHypothesis>& believed,
                                  const TruthStages& truth) const {
    return WithTruth(believed, parts_, models_, truth);
  }

  std::vector<MetricModel> models_;
  std::vector<FedPart> parts_;
};

// Off by more than a tenth of the diameter, and by less than half.
constexpr double kOff_m = 0.015;

TEST_F(TruthFeed, NothingFedChangesNothing) {
  const auto fed = Fed({Believe(0, At(0.2), 0.9), Believe(1, At(1, kOff_m), 0.4)}, {});
  ASSERT_EQ(fed.size(), 2u);
  EXPECT_TRUE(fed[0].X_CO.isApprox(At(0.2)));
  EXPECT_TRUE(fed[1].X_CO.isApprox(At(1, kOff_m)));
}

TEST_F(TruthFeed, DetectionDropsPhantomsAndProposesWhatIsMissedButMendsNoPose) {
  // A pose that is off, its duplicate, one on nothing, and one that names the wrong kind.
  const auto fed = Fed({Believe(0, At(0, kOff_m), 0.9), Believe(0, At(0, -kOff_m), 0.8),
                        Believe(0, At(0.25), 0.7), Believe(0, At(1), 0.6)},
                       {.detection = true});
  ASSERT_EQ(fed.size(), 3u);
  EXPECT_TRUE(fed[0].X_CO.isApprox(At(0, kOff_m))) << "the pose stays as wrong as it was";
  EXPECT_TRUE(fed[1].X_CO.isApprox(At(0.5)));
  EXPECT_EQ(fed[1].object, 0);
  EXPECT_DOUBLE_EQ(fed[1].score, 0.8);
  EXPECT_TRUE(fed[2].X_CO.isApprox(At(1)));
  EXPECT_EQ(fed[2].object, 1);
  EXPECT_DOUBLE_EQ(fed[2].score, 0.6);
}

TEST_F(TruthFeed, PoseMendsWhatStandsOnAPartAndProposesNothing) {
  PoseHypothesis off = Believe(0, At(0, kOff_m), 0.9);
  off.suppressed_X_CO = {At(0)};
  off.unrefined_X_CO = At(0);
  const auto fed = Fed({off, Believe(0, At(0.25), 0.7), Believe(1, At(0.5), 0.6)}, {.pose = true});
  ASSERT_EQ(fed.size(), 3u);
  EXPECT_TRUE(fed[0].X_CO.isApprox(At(0)));
  EXPECT_FALSE(fed[0].unrefined_X_CO.has_value());
  EXPECT_TRUE(fed[0].suppressed_X_CO.empty());
  EXPECT_TRUE(fed[1].X_CO.isApprox(At(0.25))) << "it stands on nothing";
  EXPECT_TRUE(fed[2].X_CO.isApprox(At(0.5))) << "it stands on a part of another kind";
}

TEST_F(TruthFeed, RefinementMendsOnlyWhatWasRightAtSomeTime) {
  PoseHypothesis undone = Believe(0, At(0, kOff_m), 0.9);
  undone.unrefined_X_CO = At(0, 0.001);
  PoseHypothesis suppressing = Believe(1, At(1, kOff_m), 0.8);
  suppressing.suppressed_X_CO = {At(0.7), At(1, 0.002)};
  PoseHypothesis never = Believe(0, At(0.5, kOff_m), 0.7);
  never.unrefined_X_CO = At(0.5, 1.2 * kOff_m);
  auto fed = Fed({undone, suppressing, never}, {.refinement = true});
  ASSERT_EQ(fed.size(), 3u);
  EXPECT_TRUE(fed[0].X_CO.isApprox(At(0)));
  EXPECT_TRUE(fed[1].X_CO.isApprox(At(1)));
  EXPECT_TRUE(fed[2].X_CO.isApprox(At(0.5, kOff_m)));
  EXPECT_TRUE(fed[2].unrefined_X_CO.has_value());
  fed = Fed({Believe(0, At(0, 0.002), 0.9)}, {.refinement = true});
  EXPECT_EQ(fed[0].X_CO.matrix(), At(0).matrix()) << "a right pose becomes exact";
}

TEST_F(TruthFeed, AllOfPerceptionIsTheTruth) {
  const auto fed = Fed({}, OracleNamed("perception").truth);
  ASSERT_EQ(fed.size(), parts_.size());
  for (size_t i = 0; i < fed.size(); ++i) {
    EXPECT_EQ(fed[i].object, parts_[i].object);
    EXPECT_EQ(fed[i].X_CO.matrix(), parts_[i].X_CO.matrix());
  }
}

TEST(OracleTable, EachStageAloneAndAllTogether) {
  EXPECT_EQ(OracleNamed("detection").truth, (TruthStages{.detection = true}));
  EXPECT_EQ(OracleNamed("pose").truth, (TruthStages{.pose = true}));
  EXPECT_EQ(OracleNamed("refinement").truth, (TruthStages{.refinement = true}));
  EXPECT_EQ(OracleNamed("grasp").truth, (TruthStages{.grasp = true}));
  EXPECT_TRUE(OracleNamed("perception").truth.AllOfPerception());
  EXPECT_FALSE(OracleNamed("perception").truth.grasp);
  EXPECT_TRUE(OracleNamed("everything").truth.AllOfPerception());
  EXPECT_TRUE(OracleNamed("everything").truth.grasp);
  EXPECT_THAT(ErrorOf([] { OracleNamed("poes"); }), HasSubstr("did you mean 'pose'?"));
}

}  // namespace
}  // namespace pickbed
