#include "perception/estimators/descriptor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "perception/candidates/estimate_trace.h"
#include "perception/estimators/first_poses.h"
#include "perception/training/training.h"
#include "perception/voting/pose_clustering.h"
#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// One small model for all tests: instances side by side, a few seconds of training.
class Descriptor : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    temporary_ = new TemporaryFolder;
    folder_ = temporary_->path();
    std::filesystem::create_directories(folder_ / "cache");
    views_ = new RayCastViews({ObjectOf(BracketMesh())});
    TrainingOptions options;
    options.clutter_scenes = 24;
    options.views_per_scene = 1;
    options.positive_pairs.patches_per_view = 120;
    options.verifier_entries = 4000;
    options.iterations = 220;
    options.batch = 64;
    options.verifier_clutter_scenes = 6;
    options.verifier_room_scenes = 0;
    options.network.descriptor = 16;
    options.loss.kind = "infonce";
    options.candidates.points = 150;
    options.candidates.candidates = 120;
    options.fast_candidates = options.candidates;
    TrainDescriptor({*views_, folder_ / "model.net", {}, false, {}, "test", {}}, options);
  }
  static void TearDownTestSuite() {
    delete views_;
    delete temporary_;
  }

  static EstimatorSetup MakeSetup() {
    EstimatorSetup setup;
    setup.objects = views_->objects();
    setup.spec.model = folder_ / "model.net";
    setup.intrinsics = SmallCamera();
    setup.working_distance_m = RayCastViews::kDistanceM;
    setup.views = views_;
    setup.cache_dir = folder_ / "cache";
    return setup;
  }
  static DescriptorOptions Options() {
    DescriptorOptions options = OptionsForMode("fast");
    options.code_entries = 6000;
    options.candidates.points = 200;
    options.candidates.candidates = 150;
    return options;
  }
  // Gives a known bin that is out of sight. The instances float in front of nothing, so no plane
  // can be fitted.
  static EstimateResult Run(PoseEstimator& estimator, const LabelledView& view, uint64_t seed = 1) {
    Rng rng(seed);
    return estimator.Estimate({view.frame, OutOfSightBin()}, rng);
  }
  static TemporaryFolder* temporary_;
  static std::filesystem::path folder_;
  static RayCastViews* views_;
};
TemporaryFolder* Descriptor::temporary_ = nullptr;
std::filesystem::path Descriptor::folder_;
RayCastViews* Descriptor::views_ = nullptr;

TEST_F(Descriptor, FindsUnoccludedInstances) {
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), Options());
  const PoseDistance distance(*views_->objects()[0]);
  int found = 0, instances = 0, top_right = 0;
  for (uint64_t seed = 5000; seed < 5006; ++seed) {
    const LabelledView view = views_->ClutterScene({seed, 1}).front();
    const EstimateResult result = Run(*estimator, view);
    for (const LabelledInstance& instance : view.instances) {
      ++instances;
      for (const PoseHypothesis& hypothesis : result.hypotheses) {
        if (distance(hypothesis.X_CO, instance.X_CO) > 0.1) continue;
        ++found;
        top_right += &hypothesis == &result.hypotheses.front();
        break;
      }
    }
  }
  EXPECT_GE(found, 0.6 * instances);
  EXPECT_GE(top_right, 5);
}

TEST_F(Descriptor, ThreadsDoNotChangePosesAndRoundsAddPoses) {
  const LabelledView view = views_->ClutterScene({8, 1}).front();
  DescriptorOptions options = Options();
  options.candidates.rounds = 2;
  EstimatorSetup setup = MakeSetup();
  const EstimateResult one = Run(*MakeDescriptorEstimator(setup, options), view);
  setup.threads = 3;
  const EstimateResult three = Run(*MakeDescriptorEstimator(setup, options), view);
  ASSERT_FALSE(one.hypotheses.empty());
  ASSERT_EQ(one.hypotheses.size(), three.hypotheses.size());
  for (size_t i = 0; i < one.hypotheses.size(); ++i) {
    EXPECT_EQ(one.hypotheses[i].score, three.hypotheses[i].score);
    EXPECT_EQ(one.hypotheses[i].X_CO.matrix(), three.hypotheses[i].X_CO.matrix());
  }
  EXPECT_GE(one.hypotheses.size(),
            Run(*MakeDescriptorEstimator(MakeSetup(), Options()), view).hypotheses.size());
}

TEST_F(Descriptor, HypothesesAreRankedScoredAndTimed) {
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), Options());
  const EstimateResult result = Run(*estimator, views_->ClutterScene({7, 1}).front());
  ASSERT_FALSE(result.hypotheses.empty());
  for (size_t i = 0; i < result.hypotheses.size(); ++i) {
    EXPECT_GE(result.hypotheses[i].score, MakeSetup().spec.min_score);
    EXPECT_LE(result.hypotheses[i].score, 1);
    if (i > 0) {
      EXPECT_LE(result.hypotheses[i].score, result.hypotheses[i - 1].score);
    }
  }
  for (const char* stage : {"cloud", "patches", "network", "neighbors", "quick", "icp",
                            "ambiguous_poses", "verify", "non_maximum_suppression", "refine"}) {
    EXPECT_TRUE(result.seconds.contains(stage)) << stage;
  }
}

TEST_F(Descriptor, SameSeedGivesTheSameResult) {
  const LabelledView view = views_->ClutterScene({8, 1}).front();
  const EstimateResult first = Run(*MakeDescriptorEstimator(MakeSetup(), Options()), view);
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), Options());
  Run(*estimator, views_->ClutterScene({9, 1}).front());
  const EstimateResult second = Run(*estimator, view);
  ASSERT_FALSE(first.hypotheses.empty());
  ASSERT_EQ(first.hypotheses.size(), second.hypotheses.size());
  for (size_t i = 0; i < first.hypotheses.size(); ++i) {
    EXPECT_EQ(first.hypotheses[i].score, second.hypotheses[i].score);
    EXPECT_EQ(first.hypotheses[i].X_CO.matrix(), second.hypotheses[i].X_CO.matrix());
  }
}

EstimateTrace TraceOf(PoseEstimator& estimator, const EstimatorInput& input,
                      EstimateResult* result = nullptr) {
  EstimateTrace trace;
  Rng rng(1);
  EstimatorInput traced = input;
  traced.trace = &trace;
  const EstimateResult found = estimator.Estimate(traced, rng);
  if (result) *result = found;
  return trace;
}

TEST_F(Descriptor, OnlyCrowdedScenesWithAKnownBackgroundGetMoreRounds) {
  const LabelledView view = views_->ClutterScene({8, 1}).front();
  const auto patches = [&](std::optional<KnownBackground> background, double usual_instances,
                           int crowded_rounds, double later_density = 4, int rounds = 1) {
    DescriptorOptions options = Options();
    options.candidates.usual_instances = usual_instances;
    options.candidates.crowded_rounds = crowded_rounds;
    options.candidates.rounds = rounds;
    options.candidates.later_density = later_density;
    options.candidates.candidates = options.candidates.min_candidates = 1;  // few are found
    const auto estimator = MakeDescriptorEstimator(MakeSetup(), options);
    return TraceOf(*estimator, {view.frame, std::move(background)}).patches.size();
  };
  EXPECT_GT(patches(OutOfSightBin(), 1, 2), patches(OutOfSightBin(), 1, 1));
  EXPECT_EQ(patches(OutOfSightBin(), 100, 2), patches(OutOfSightBin(), 100, 1));
  EXPECT_GT(patches(OutOfSightBin(), 1, 2), patches(OutOfSightBin(), 1, 2, 0.1));
  ASSERT_GT(patches(OutOfSightBin(), 2.5, 1), patches(OutOfSightBin(), 100, 1)) << "more area";
  EXPECT_EQ(patches(OutOfSightBin(), 2.5, 2), patches(OutOfSightBin(), 2.5, 1))
      << "too few are found";
  EXPECT_GT(patches(OutOfSightBin(), 100, 1, 4, 2), patches(OutOfSightBin(), 100, 1));
  ASSERT_GT(patches({}, 1, 1), patches({}, 100, 1)) << "it is crowded, too";
  EXPECT_EQ(patches({}, 1, 2), patches({}, 1, 1));
}

TEST_F(Descriptor, TracingDoesNotChangeTheResult) {
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), Options());
  const LabelledView view = views_->ClutterScene({12, 1}).front();
  const EstimateResult plain = Run(*estimator, view);
  EstimateResult traced;
  TraceOf(*estimator, {view.frame, OutOfSightBin()}, &traced);
  ASSERT_FALSE(plain.hypotheses.empty());
  ASSERT_EQ(plain.hypotheses.size(), traced.hypotheses.size());
  for (size_t i = 0; i < plain.hypotheses.size(); ++i) {
    const PoseHypothesis &a = plain.hypotheses[i], &b = traced.hypotheses[i];
    EXPECT_EQ(a.object, b.object);
    EXPECT_EQ(a.score, b.score);
    EXPECT_EQ(a.X_CO.matrix(), b.X_CO.matrix());
    EXPECT_EQ(a.fit.inlier_share, b.fit.inlier_share);
  }
}

TEST_F(Descriptor, CompletionAddsCandidatesAndIsReproducible) {
  const LabelledView view = views_->ClutterScene({12, 1}).front();
  const auto candidates = [&](const EstimatorSetup& setup) {
    Rng rng(1);
    EstimateTrace trace;
    MakeDescriptorEstimator(setup, Options())->Estimate({view.frame, OutOfSightBin(), &trace}, rng);
    return trace.candidates;
  };
  EstimatorSetup setup = MakeSetup();
  const auto without = candidates(setup);
  setup.spec.completion = "skirt";
  const auto with = candidates(setup);
  EXPECT_GT(with.size(), without.size());
  const auto again = candidates(setup);
  ASSERT_EQ(with.size(), again.size());
  for (size_t i = 0; i < with.size(); ++i) {
    EXPECT_EQ(with[i].hypothesis.X_CO.matrix(), again[i].hypothesis.X_CO.matrix());
  }
  setup.spec.mode = kFirstMode;
  EXPECT_THAT(ErrorOf([&] { candidates(setup); }), HasSubstr("choose mode fast or accurate"));
}

TEST_F(Descriptor, PatchesNeverExceedThePoints) {
  DescriptorOptions options = Options();
  options.candidates.points = 100;
  options.candidates.min_points = 60;
  const LabelledView view = views_->ClutterScene({12, 1}).front();
  const auto patches = [&] {
    return TraceOf(*MakeDescriptorEstimator(MakeSetup(), options), {view.frame, OutOfSightBin()})
        .patches.size();
  };
  EXPECT_EQ(patches(), 100u);
  options.candidates.min_points = 120;
  EXPECT_EQ(patches(), 100u) << "never more than points";
}

TEST_F(Descriptor, StagesOfATraceAreConsistent) {
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), Options());
  const LabelledView view = views_->ClutterScene({12, 1}).front();
  const EstimateTrace trace = TraceOf(*estimator, {view.frame, OutOfSightBin()});
  ASSERT_EQ(trace.patches.size(), static_cast<size_t>(Options().candidates.points));
  EXPECT_EQ(trace.votes.size(), trace.patches.size() * trace.neighbors);
  for (const TracedPatch& patch : trace.patches) {
    ASSERT_TRUE(trace.cloud.foreground.data()[patch.pixel]);
    const Eigen::Vector3d point_C = trace.cloud.points_C[patch.pixel].cast<double>();
    EXPECT_TRUE(patch.X_CP.translation() == point_C);
  }
  for (size_t i = 0; i < trace.votes.size(); ++i) {
    ASSERT_EQ(trace.votes[i].patch, static_cast<int>(i) / trace.neighbors);
    if (i % trace.neighbors > 0) {
      EXPECT_GE(trace.votes[i].distance, trace.votes[i - 1].distance);
    }
  }
  const auto same = [](const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); };
  for (const TracedRefinement& refinement : trace.refinements) {
    EXPECT_NE(refinement.ambiguous_pose,
              std::ranges::any_of(trace.votes, [&](const TracedVote& vote) {
                return same(vote.vote.X_CO, refinement.before.X_CO);
              }));
  }
  const std::vector<ModelPoints> models{MakeModelPoints(*views_->objects()[0])};
  ASSERT_FALSE(trace.candidates.empty());
  for (const TracedCandidate& candidate : trace.candidates) {
    const Pose& X_CO = candidate.hypothesis.X_CO;
    EXPECT_TRUE(std::ranges::any_of(trace.refinements, [&](const TracedRefinement& refinement) {
      return same(refinement.after.X_CO, X_CO);
    }));
    const std::vector<JudgedPoint> points = JudgePoints(trace.cloud, models[0], X_CO);
    const auto violations = std::ranges::count(points, PointFit::kViolates, &JudgedPoint::fit);
    EXPECT_NEAR(violations, candidate.features[2] * points.size(), 0.01);
  }
  ASSERT_FALSE(trace.accepted.empty());
  for (const PoseHypothesis& accepted : trace.accepted) {
    EXPECT_GE(accepted.score, trace.min_score);
    EXPECT_TRUE(std::ranges::any_of(trace.candidates, [&](const TracedCandidate& candidate) {
      return same(candidate.hypothesis.X_CO, accepted.X_CO) &&
             candidate.hypothesis.score == accepted.score;
    }));
  }
}

TEST_F(Descriptor, CodebookIsMadeOnceAndThenRead) {
  EstimatorSetup setup = MakeSetup();
  setup.cache_dir = folder_ / "other cache";
  std::filesystem::create_directories(setup.cache_dir);
  double share = 0;
  setup.on_progress = [&](std::string_view what, double done) {
    EXPECT_THAT(std::string(what), HasSubstr("test part"));
    share = done;
  };
  const int before = views_->isolated_calls();
  MakeDescriptorEstimator(setup, Options());
  EXPECT_GT(views_->isolated_calls(), before);
  EXPECT_EQ(share, 1.0);

  const int made = views_->isolated_calls();
  MakeDescriptorEstimator(setup, Options());
  EXPECT_EQ(views_->isolated_calls(), made);

  DescriptorOptions larger = Options();
  larger.code_entries += 100;
  MakeDescriptorEstimator(setup, larger);
  EXPECT_GT(views_->isolated_calls(), made);
  setup.views = nullptr;
  EXPECT_THAT(ErrorOf([&] { MakeDescriptorEstimator(setup, Options()); }), HasSubstr("renderer"));
}

TEST_F(Descriptor, DamagedCodebookIsReportedOnceAndMadeAgain) {
  EstimatorSetup setup = MakeSetup();
  setup.cache_dir = folder_ / "damaged cache";
  MakeDescriptorEstimator(setup, Options());
  const std::filesystem::path file = std::filesystem::directory_iterator(setup.cache_dir)->path();
  const std::string bytes = ReadFileBytes(file);
  std::string damaged = bytes;
  damaged[bytes.size() / 2] ^= 0x40;
  std::vector<std::string> lines;
  SetCacheListener([&](const std::string& line) { lines.push_back(line); });
  for (const std::string& content : {damaged, bytes.substr(0, bytes.size() / 2), std::string()}) {
    WriteFileAtomically(file, content);
    lines.clear();
    MakeDescriptorEstimator(setup, Options());
    EXPECT_EQ(ReadFileBytes(file), bytes);
    ASSERT_FALSE(lines.empty());
    EXPECT_THAT(lines.front(), AllOf(HasSubstr(file.string()), HasSubstr("it is made again")));
  }
  SetCacheListener({});
}

TEST_F(Descriptor, CodebookOfAnotherSensorIsNotRead) {
  EstimatorSetup setup = MakeSetup();
  setup.cache_dir = folder_ / "two sensors";
  std::filesystem::create_directories(setup.cache_dir);
  RayCastViews still(setup.objects, 0), noisy(setup.objects, 0.002);
  for (RayCastViews* views : {&still, &noisy}) {
    setup.views = views;
    MakeDescriptorEstimator(setup, Options());
    EXPECT_GT(views->isolated_calls(), 0);
  }
}

TEST_F(Descriptor, EmptyFrameGivesNoHypothesis) {
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), Options());
  LabelledView empty;
  empty.frame.intrinsics = SmallCamera();
  empty.frame.depth_m = Image<float>(SmallCamera().width(), SmallCamera().height());
  EXPECT_TRUE(Run(*estimator, empty).hypotheses.empty());
}

TEST_F(Descriptor, FirstModeStopsWhenEnoughReachablePosesAreFound) {
  const LabelledView view = views_->ClutterScene({5001, 1}).front();
  DescriptorOptions options = Options();
  options.first.emplace();
  options.first->poses = 1;
  options.first->confidence = 0;
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), options);
  EstimatorInput input{view.frame, OutOfSightBin()};
  const auto candidates_of = [&] {
    EstimateTrace trace;
    input.trace = &trace;
    Rng rng(1);
    estimator->Estimate(input, rng);
    return trace.candidates.size();
  };
  const size_t at_once = candidates_of();
  EXPECT_GT(at_once, 0u);
  // Without a reachable pose, all of the foreground is searched.
  size_t asked = 0;
  input.count_reachable = [&](std::span<const PoseHypothesis>, int) {
    ++asked;
    return 0;
  };
  const size_t in_vain = candidates_of();
  EXPECT_GT(in_vain, at_once);
  EXPECT_GT(asked, 1u);
  input.count_reachable = [](std::span<const PoseHypothesis>, int wanted) { return wanted; };
  EXPECT_EQ(candidates_of(), at_once);
}

TEST_F(Descriptor, FirstModeRanksARightPoseFirst) {
  DescriptorOptions options = Options();
  options.first.emplace();
  options.first->poses = 1;
  options.first->confidence = 0.3;
  const auto estimator = MakeDescriptorEstimator(MakeSetup(), options);
  const PoseDistance distance(*views_->objects()[0]);
  int right = 0, poses = 0;
  for (uint64_t seed = 5000; seed < 5006; ++seed) {
    const LabelledView view = views_->ClutterScene({seed, 1}).front();
    const EstimateResult result = Run(*estimator, view);
    if (result.hypotheses.empty()) continue;
    ++poses;
    right += std::ranges::any_of(view.instances, [&](const LabelledInstance& instance) {
      return distance(result.hypotheses.front().X_CO, instance.X_CO) < 0.1;
    });
  }
  EXPECT_GE(poses, 5);
  EXPECT_GE(right, poses - 1);
}

TEST_F(Descriptor, BadSetupsAreRefused) {
  EstimatorSetup setup = MakeSetup();
  setup.spec.mode = "fsat";
  EXPECT_THAT(ErrorOf([&] { MakeDescriptorEstimator(setup); }), HasSubstr("did you mean 'fast'"));
  setup = MakeSetup();
  setup.spec.model = "no_such_model";
  EXPECT_THAT(ErrorOf([&] { MakeDescriptorEstimator(setup); }), HasSubstr("no_such_model"));
  setup = MakeSetup();
  auto stranger = std::make_shared<ObjectModel>(*setup.objects[0]);
  stranger->name = "stranger";
  setup.objects = {stranger};
  EXPECT_THAT(ErrorOf([&] { MakeDescriptorEstimator(setup); }), HasSubstr("object 'stranger'"));
}

TEST(OptionsForMode, AccurateModeDoesMoreWorkThanFast) {
  const DescriptorOptions fast = OptionsForMode("fast");
  const DescriptorOptions accurate = OptionsForMode("accurate");
  EXPECT_GT(accurate.candidates.points, fast.candidates.points);
  EXPECT_GT(accurate.candidates.candidates, fast.candidates.candidates);
  EXPECT_TRUE(accurate.candidates.two_correspondence_distances);
}

}  // namespace
}  // namespace pickbed::tests
