#include "perception/candidates/candidate_refinement.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "perception/verify/physical_consistency.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A clutter scene of brackets, with votes near each true pose and votes with random rotations.
class RefinedCandidates : public testing::Test {
 protected:
  RefinedCandidates() : views_({ObjectOf(BracketMesh())}) { LookAt(21); }

  void LookAt(uint64_t scene) {
    view_ = views_.ClutterScene({scene, 1}).front();
    cloud_ = BuildCloud(view_.frame, OutOfSightBin());
    votes_.clear();
    Rng rng(5);
    for (const LabelledInstance& instance : view_.instances) {
      for (int i = 0; i < 3; ++i) {
        const Pose rough = Perturbed(instance.X_CO, rng.UnitVector(), rng.Uniform(0, 4),
                                     rng.Uniform(0, 0.002) * rng.UnitVector());
        votes_.push_back({rough, static_cast<int>(votes_.size())});
      }
      Pose wrong = Translation(0.02 * rng.UnitVector()) * instance.X_CO;
      wrong.linear() = rng.Rotation().toRotationMatrix();
      votes_.push_back({wrong, static_cast<int>(votes_.size())});
    }
  }

  std::vector<Candidate> RefineCandidates(const CandidateRefinementOptions& options,
                                          int threads = 1, double share = 1) const {
    const CandidateRefiner candidate_refiner(views_.objects(), options, threads);
    StageSeconds seconds;
    auto candidates = candidate_refiner.RefineCandidates(
        cloud_, ObjectId{0}, votes_, static_cast<int>(votes_.size()), {.share = share}, seconds);
    candidate_refiner.Compare(candidates, seconds);
    return candidates;
  }

  double Error(const Pose& X_CO) const {
    const PoseDistance distance(*views_.objects()[0]);
    double smallest = 1e9;
    for (const LabelledInstance& instance : view_.instances) {
      smallest = std::min<double>(smallest, distance(X_CO, instance.X_CO));
    }
    return smallest;
  }

  RayCastViews views_;
  LabelledView view_;
  OrganizedCloud cloud_;
  std::vector<PoseVote> votes_;
};

TEST_F(RefinedCandidates, EveryVisibleInstanceHasACandidate) {
  const PoseDistance distance(*views_.objects()[0]);
  const std::vector<Candidate> candidates = RefineCandidates({});
  int visible = 0;
  for (const LabelledInstance& instance : view_.instances) {
    if (instance.visible_fraction < 0.3) continue;
    ++visible;
    const bool found =
        std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
          return distance(candidate.hypothesis.X_CO, instance.X_CO) < 0.05;
        });
    EXPECT_TRUE(found);
  }
  EXPECT_GT(visible, 0);
}

// Without a verifier, evidence already ranks right poses above wrong ones.
TEST_F(RefinedCandidates, RightPosesHaveMoreEvidenceThanRivals) {
  int right = 0, above = 0;
  for (const Candidate& candidate : RefineCandidates({})) {
    if (Error(candidate.hypothesis.X_CO) > 0.05) continue;
    ++right;
    above += candidate.features[kMarginFeature] > 0;
  }
  EXPECT_GT(right, 3);
  EXPECT_GT(above, 0.8 * right);
}

TEST_F(RefinedCandidates, PoseWithoutRivalHasTheLargestMargin) {
  votes_.resize(1);
  CandidateRefinementOptions options;
  options.ambiguous_candidates = 0;
  const std::vector<Candidate> candidates = RefineCandidates(options);
  ASSERT_EQ(candidates.size(), 1u);
  EXPECT_EQ(candidates[0].features[kMarginFeature], 1);
}

TEST_F(RefinedCandidates, PoseInsideAnEvidentCandidateOverlaps) {
  const CandidateRefiner candidate_refiner(views_.objects(), {});
  std::vector<Candidate> candidates = RefineCandidates({});
  const auto evident = std::max_element(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.evidence < b.evidence; });
  ASSERT_LT(Error(evident->hypothesis.X_CO), 0.05);
  // Largest overlap of the pose moved along one of the axes.
  const auto overlap_of = [&](double moved_diameters) {
    float largest = 0;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d way = (i < 3 ? 1 : -1) * Eigen::Vector3d::Unit(i % 3);
      Candidate other = *evident;
      other.features = {};
      other.hypothesis.X_CO = Translation(moved_diameters * views_.objects()[0]->diameter_m * way) *
                              evident->hypothesis.X_CO;
      std::vector<Candidate> both{*evident, other};
      StageSeconds seconds;
      candidate_refiner.Compare(both, seconds);
      EXPECT_EQ(both[0].features[kOverlapFeature], 0) << "the other one is not evident";
      largest = std::max(largest, both[1].features[kOverlapFeature]);
    }
    return largest;
  };
  EXPECT_GT(overlap_of(0.25), 0.02);
  EXPECT_EQ(overlap_of(0.1), 0) << "another pose at the same place is a rival";
  EXPECT_EQ(overlap_of(1.2), 0);
}

TEST_F(RefinedCandidates, ShareLimitsTheRefinedCandidates) {
  CandidateRefinementOptions options;
  options.ambiguous_candidates = 0;
  options.min_quick_score = -1;
  options.candidates = options.min_candidates = 8;
  EXPECT_LE(RefineCandidates(options, 1, 0.5).size(), 4u);
  EXPECT_GT(RefineCandidates(options, 1, 1).size(), 4u);
}

TEST_F(RefinedCandidates, FittedBackgroundRefinesMoreCandidates) {
  CandidateRefinementOptions options;
  options.ambiguous_candidates = 0;
  options.min_quick_score = -1;
  options.candidates = options.min_candidates = 4;
  EXPECT_LE(RefineCandidates(options).size(), 4u);
  cloud_.background = BackgroundKind::kFitted;
  EXPECT_GT(RefineCandidates(options).size(), 4u);
  options.fitted_background_factor = 1;
  EXPECT_LE(RefineCandidates(options).size(), 4u);
}

TEST_F(RefinedCandidates, LowQuickScoresAreRejected) {
  CandidateRefinementOptions options;
  options.min_quick_score = 0.5;
  const std::vector<Candidate> candidates = RefineCandidates(options);
  EXPECT_FALSE(candidates.empty());
  EXPECT_LT(candidates.size(), RefineCandidates({}).size());
  for (const Candidate& candidate : candidates) EXPECT_GE(candidate.hypothesis.score, 0.5);
}

TEST_F(RefinedCandidates, CandidatesAreDistinctPoses) {
  const PoseDistance distance(*views_.objects()[0]);
  CandidateRefinementOptions options;
  const std::vector<Candidate> candidates = RefineCandidates(options);
  for (size_t i = 0; i < candidates.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GE(distance(candidates[i].hypothesis.X_CO, candidates[j].hypothesis.X_CO),
                options.merge_diameters);
    }
  }
}

// With the noise of a depth camera, few points do not determine the pose well.
TEST_F(RefinedCandidates, FineIcpStepsImproveThePose) {
  constexpr double kNoise_m = 0.0015;
  RayCastViews noisy(views_.objects(), kNoise_m);
  const PoseDistance distance(*noisy.objects()[0]);
  const auto error = [&](int fine_steps) {
    CandidateRefinementOptions options;
    options.fine_steps = fine_steps;
    options.ambiguous_candidates = 0;
    options.two_correspondence_distances = false;
    const CandidateRefiner candidate_refiner(noisy.objects(), options);
    double sum = 0;
    for (uint64_t seed = 0; seed < 8; ++seed) {
      const LabelledView view = noisy.ClutterScene({seed, 1}).front();
      Rng rng(seed);
      for (const LabelledInstance& instance : view.instances) {
        const Pose rough = Perturbed(instance.X_CO, rng.UnitVector(), 3, {0, 0, 0});
        StageSeconds seconds;
        const auto found = candidate_refiner.RefineCandidates(
            BuildCloud(view.frame, OutOfSightBin()), ObjectId{0}, {{rough, 0}}, 1, {}, seconds);
        for (const Candidate& candidate : found) {
          sum += distance(candidate.hypothesis.X_CO, instance.X_CO);
        }
      }
    }
    return sum;
  };
  EXPECT_LT(error(10), 0.9 * error(0));
}

TEST_F(RefinedCandidates, ObjectsShareTheBudgetOfAmbiguousPoses) {
  CandidateRefinementOptions options;
  options.candidates = 40;
  options.min_candidates = 10;
  options.ambiguous_candidates = 8;
  options.ambiguous_poses = 1;
  options.min_quick_score = -1;
  const auto tried = [&](const ObjectSet& objects) {
    const CandidateRefiner candidate_refiner(objects, options);
    StageSeconds seconds;
    EstimateTrace trace;
    candidate_refiner.RefineCandidates(cloud_, ObjectId{0}, votes_, static_cast<int>(votes_.size()),
                                       {}, seconds, &trace);
    return std::count_if(trace.refinements.begin(), trace.refinements.end(),
                         [](const auto& refinement) { return refinement.ambiguous_pose; });
  };
  const auto& bracket = views_.objects()[0];
  EXPECT_GT(tried({bracket}), 4);
  EXPECT_EQ(tried({bracket, bracket, bracket, bracket}), 2);
}

// The floor is first far below the instances, then a quarter of a diameter above their deepest
// point.
TEST_F(RefinedCandidates, AmbiguousPosesInsideTheFloorAreNotTried) {
  constexpr double kMaxOutsideDiameters = 0.1;
  const ObjectModel& bracket = *views_.objects()[0];
  const ModelPoints points = MakeModelPoints(bracket);
  float deepest_m = 0;
  for (const LabelledInstance& instance : view_.instances) {
    for (const Eigen::Vector3f& p_O : points.points_O) {
      deepest_m = std::max(deepest_m, (instance.X_CO.cast<float>() * p_O).z());
    }
  }
  const float quarter_m = 0.25f * static_cast<float>(bracket.diameter_m);
  struct Tried {
    int inside = 0, outside = 0;
  };
  const auto tried = [&](float floor_m) {
    cloud_.planes = {{-Eigen::Vector3f::UnitZ(), -floor_m}};
    const CandidateRefiner candidate_refiner(views_.objects(), {});
    StageSeconds seconds;
    EstimateTrace trace;
    candidate_refiner.RefineCandidates(cloud_, ObjectId{0}, votes_, static_cast<int>(votes_.size()),
                                       {}, seconds, &trace);
    Tried counts;
    for (const TracedRefinement& refinement : trace.refinements) {
      if (!refinement.ambiguous_pose) continue;
      const float outside_m = MeasureContainment(cloud_, points, refinement.before.X_CO).outside_m;
      ++(outside_m > kMaxOutsideDiameters * bracket.diameter_m ? counts.outside : counts.inside);
    }
    return counts;
  };
  const Tried far = tried(10), near = tried(deepest_m - quarter_m);
  EXPECT_EQ(near.outside, 0);
  EXPECT_GT(near.inside, 0);
  EXPECT_LT(near.inside, far.inside);
}

// Ambiguous poses are tried for one vote. In some scenes, it is not the pose with most evidence.
TEST_F(RefinedCandidates, RivalsOfTheBestPoseAreAdded) {
  const PoseDistance distance(*views_.objects()[0]);
  const Eigen::Vector3d center_O = views_.objects()[0]->mass.com_O;
  int added = 0;
  for (uint64_t scene = 0; scene < 12; ++scene) {
    LookAt(scene);
    CandidateRefinementOptions options;
    options.ambiguous_candidates = 1;
    const std::vector<Candidate> without = RefineCandidates(options);
    options.rivals_of_best = true;
    const std::vector<Candidate> with = RefineCandidates(options);
    ASSERT_GE(with.size(), without.size());
    const Candidate& best = *std::ranges::max_element(without, {}, &Candidate::evidence);
    for (size_t i = 0; i < with.size(); ++i) {
      const Pose& X_CO = with[i].hypothesis.X_CO;
      if (i < without.size()) {
        EXPECT_EQ(X_CO.matrix(), without[i].hypothesis.X_CO.matrix());
        continue;
      }
      ++added;
      const double moved_m = (X_CO * center_O - best.hypothesis.X_CO * center_O).norm();
      EXPECT_LT(moved_m, 0.3 * distance.diameter_m());
      for (const Candidate& other : without) {
        EXPECT_GE(distance(X_CO, other.hypothesis.X_CO), options.merge_diameters);
      }
    }
  }
  EXPECT_GT(added, 0);
}

TEST_F(RefinedCandidates, ResultIsIndependentOfThreads) {
  const std::vector<Candidate> one = RefineCandidates({}, 1), three = RefineCandidates({}, 3);
  ASSERT_EQ(one.size(), three.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].hypothesis.X_CO.matrix(), three[i].hypothesis.X_CO.matrix());
    EXPECT_EQ(one[i].features, three[i].features);
  }
}

TEST_F(RefinedCandidates, TruePosesExplainTheirPixels) {
  const CandidateRefiner candidate_refiner(views_.objects(), {});
  const std::vector<int>& all = cloud_.foreground_pixels;
  EXPECT_EQ(candidate_refiner.Unexplained(cloud_, {}, all), all);
  const std::vector<Candidate> candidates = RefineCandidates({});
  const std::vector<int> left = candidate_refiner.Unexplained(cloud_, candidates, all);
  EXPECT_LT(left.size(), 0.5 * all.size());
  EXPECT_TRUE(std::includes(all.begin(), all.end(), left.begin(), left.end()));
  // Poses that contradict the depth image explain nothing.
  std::vector<Candidate> lifted = candidates;
  for (Candidate& candidate : lifted) candidate.features[kViolatedFeature] = 0.5f;
  EXPECT_EQ(candidate_refiner.Unexplained(cloud_, lifted, all), all);
}

}  // namespace
}  // namespace pickbed::tests
