#include "perception/estimators/ppf_verified.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "perception/estimators/ppf.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/verifier_library.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// Coarser than by default, for speed.
VerifiedPpfOptions Options() {
  VerifiedPpfOptions options;
  options.match.model_sampling = 0.1;
  options.match.scene_voxel_diameters = 0.06;
  options.refinement.candidates = 60;
  options.refinement.min_candidates = 20;
  options.refinement.ambiguous_candidates = 3;
  return options;
}

VerifierTrainingOptions TinyTraining() {
  VerifierTrainingOptions options;
  options.clutter_scenes = 3;
  options.room_scenes = 0;
  options.views_per_scene = 1;
  options.verifier.iterations = 300;
  return options;
}

// For tests that do not depend on the quality of the verifiers.
VerifierTrainingOptions MinimalTraining() {
  VerifierTrainingOptions options = TinyTraining();
  options.clutter_scenes = 1;
  options.verifier.iterations = 30;
  return options;
}

// Instances that float inside a bin so large that it removes none of their pixels. All instances of
// a clutter scene are of the requested object.
class FloatingInstances : public RayCastViews {
 public:
  using RayCastViews::RayCastViews;
  std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) override {
    std::vector<LabelledView> clutter_scenes =
        RayCastViews({objects()[request.object]}).ClutterScene(request);
    KnownBackground background;
    background.bin.inner_size_m = {5, 5, 5};
    background.X_CB = Translation({0, 0, -1});
    for (LabelledView& view : clutter_scenes) {
      view.background = background;
      for (LabelledInstance& instance : view.instances) instance.object = request.object;
    }
    return clutter_scenes;
  }
};

class VerifiedPpf : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    temporary_ = new TemporaryFolder;
    views_ = new FloatingInstances({ObjectOf(BracketMesh())});
    file_ = temporary_->path() / "ppf.net";
    TrainVerifierLibrary(Job(file_), TinyTraining());
  }
  static void TearDownTestSuite() {
    delete views_;
    delete temporary_;
  }

  static VerifierJob Job(const std::filesystem::path& file) {
    return {*views_,
            "ppf",
            [](const ObjectSet& objects, const LearnedNetwork&) {
              return MakePpfCandidates(objects, Options());
            },
            file,
            false,
            "test sensor",
            {}};
  }
  static EstimatorSetup MakeSetup() {
    EstimatorSetup setup;
    setup.objects = views_->objects();
    setup.spec.name = "ppf";
    setup.spec.mode = kVerifiedMode;
    setup.spec.model = file_;
    setup.intrinsics = SmallCamera();
    return setup;
  }
  static LabelledView ClutterScene(uint64_t seed) {
    return views_->ClutterScene({seed, 1, ObjectId{0}, true}).front();
  }

  struct Count {
    int right = 0, wrong = 0;
  };
  // Counts each instance once.
  static Count Judge(const std::vector<PoseHypothesis>& poses, const LabelledView& view) {
    const PoseDistance distance(*views_->objects()[0]);
    std::set<size_t> found;
    Count count;
    for (const PoseHypothesis& pose : poses) {
      const size_t before = found.size();
      for (size_t i = 0; i < view.instances.size(); ++i) {
        if (distance(pose.X_CO, view.instances[i].X_CO) < 0.1) found.insert(i);
      }
      ++(found.size() > before ? count.right : count.wrong);
    }
    return count;
  }

  static inline TemporaryFolder* temporary_ = nullptr;
  static inline FloatingInstances* views_ = nullptr;
  static inline std::filesystem::path file_;
};

TEST_F(VerifiedPpf, FindsMoreThanPlainPpfAtNoLowerPrecision) {
  const auto verified = MakeVerifiedPpfEstimator(MakeSetup(), Options());
  PpfOptions plain_options;
  plain_options.match.model_sampling = Options().match.model_sampling;
  plain_options.match.scene_voxel_diameters = Options().match.scene_voxel_diameters;
  const auto plain = MakePpfEstimator(MakeSetup(), plain_options);
  Count with, without;
  for (const uint64_t seed : {100, 101, 102}) {
    const LabelledView view = ClutterScene(seed);
    Rng rng(0);
    const Count a = Judge(verified->Estimate({view.frame, view.background}, rng).hypotheses, view);
    const Count b = Judge(plain->Estimate({view.frame, view.background}, rng).hypotheses, view);
    with = {with.right + a.right, with.wrong + a.wrong};
    without = {without.right + b.right, without.wrong + b.wrong};
  }
  EXPECT_GT(with.right, without.right);
  EXPECT_GE(with.right, 7);  // of nine
  EXPECT_LE(with.wrong * std::max(1, without.right), std::max(1, without.wrong) * with.right);
}

// The features of the verifier describe the refined pose in the image and its margin to its rivals.
// A proposal without candidate refinement would have neither.
TEST_F(VerifiedPpf, CandidatesAreRefinedAndMeasured) {
  const LabelledView view = ClutterScene(100);
  const OrganizedCloud cloud = BuildCloud(view.frame, view.background);
  const auto source = MakePpfCandidates(views_->objects(), Options());
  Rng rng(0);
  StageSeconds seconds;
  const std::vector<Candidate> candidates = source->Find(cloud, rng, seconds);
  ASSERT_GT(candidates.size(), 10u);
  bool rivals = false;
  for (const Candidate& candidate : candidates) {
    const FitReport fit =
        MeasureFit(cloud, source->candidate_refiner().model_points()[0], candidate.hypothesis.X_CO);
    EXPECT_EQ(candidate.hypothesis.fit.inlier_share, fit.inlier_share);
    EXPECT_EQ(candidate.features[0], static_cast<float>(fit.inlier_share));
    rivals |= candidate.features[kMarginFeature] < 0;
  }
  EXPECT_TRUE(rivals);
  for (const char* stage : {"match", "quick", "select", "icp", "verify"}) {
    EXPECT_TRUE(seconds.contains(stage)) << stage;
  }
}

// A window contains a whole instance, so cutting the scene loses none of its poses.
TEST_F(VerifiedPpf, WindowsLoseNoInstance) {
  const LabelledView view = ClutterScene(103);
  const OrganizedCloud cloud = BuildCloud(view.frame, view.background);
  const ModelPoints model = MakeModelPoints(*views_->objects()[0]);
  const PoseDistance distance(*views_->objects()[0]);
  const auto near_truth = [&](double window_diameters) {
    PpfMatchOptions options = Options().match;
    options.model_sampling = 0.08;  // with 0.1, one is found only in the whole scene
    options.window_diameters = window_diameters;
    const PpfMatcher matcher(model, options);
    const std::vector<Pose> poses = matcher.Match(matcher.SceneRows(cloud));
    std::vector<int> counts;
    for (const LabelledInstance& instance : view.instances) {
      counts.push_back(
          static_cast<int>(std::count_if(poses.begin(), poses.end(), [&](const Pose& X_CO) {
            return distance(X_CO, instance.X_CO) < 0.25;
          })));
    }
    return counts;
  };
  const std::vector<int> whole = near_truth(0), cut = near_truth(2);
  for (size_t i = 0; i < whole.size(); ++i) {
    EXPECT_GE(cut[i], std::min(1, whole[i])) << i;
  }
  EXPECT_GT(std::count_if(cut.begin(), cut.end(), [](int n) { return n > 0; }), 0);
}

TEST_F(VerifiedPpf, ReportsNoMoreThanTheGivenCount) {
  const auto estimator = MakeVerifiedPpfEstimator(MakeSetup(), Options());
  const LabelledView view = ClutterScene(104);
  const auto number_of_poses = [&](std::vector<int> instances) {
    Rng rng(0);
    return estimator->Estimate({view.frame, view.background, nullptr, std::move(instances)}, rng)
        .hypotheses.size();
  };
  ASSERT_GT(number_of_poses({}), 1u);
  EXPECT_EQ(number_of_poses({1}), 1u);
  EXPECT_EQ(number_of_poses({0}), 0u);
}

TEST_F(VerifiedPpf, SameSeedSameVerifiersAndPoses) {
  const auto once = temporary_->path() / "once.net", again = temporary_->path() / "again.net",
             other = temporary_->path() / "other.net";
  TrainVerifierLibrary(Job(once), MinimalTraining());
  TrainVerifierLibrary(Job(again), MinimalTraining());
  const auto score = [](const std::filesystem::path& file) {
    return LoadVerifiers(file, "ppf").verifiers.at(0).Score(VerifyFeatures{});
  };
  EXPECT_EQ(score(again), score(once));
  VerifierTrainingOptions options = MinimalTraining();
  options.seed = 1;
  TrainVerifierLibrary(Job(other), options);
  EXPECT_NE(score(other), score(once));

  const auto estimator = MakeVerifiedPpfEstimator(MakeSetup(), Options());
  const LabelledView view = ClutterScene(104);
  Rng one(1), two(2);
  const auto first = estimator->Estimate({view.frame, view.background}, one).hypotheses;
  const auto second = estimator->Estimate({view.frame, view.background}, two).hypotheses;
  ASSERT_FALSE(first.empty());
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].X_CO.matrix(), second[i].X_CO.matrix());
    EXPECT_EQ(first[i].score, second[i].score);
  }
}

TEST_F(VerifiedPpf, UnsuitableFilesAreRefusedWithARemedy) {
  EstimatorSetup setup = MakeSetup();
  auto changed = std::make_shared<ObjectModel>(*setup.objects[0]);
  changed->mesh_hash += 1;
  setup.objects = {changed};
  EXPECT_THAT(ErrorOf([&] { MakePpfEstimator(setup); }),
              testing::AllOf(HasSubstr("ppf.net: the mesh of object 'test part' has changed"),
                             HasSubstr("`pickbed train` as verifiers of ppf")));
  changed->name = "widget";
  EXPECT_THAT(ErrorOf([&] { MakePpfEstimator(setup); }),
              HasSubstr("not trained for object 'widget' (knows test part)"));
  EXPECT_THAT(ErrorOf([&] { LoadVerifiers(file_, "linemod"); }), HasSubstr("are for 'ppf'"));
  EXPECT_THAT(ErrorOf([&] { LoadVerifiers(temporary_->path() / "no.net", "ppf"); }),
              HasSubstr("no.net: the verifier file does not exist"));
  EXPECT_THAT(ErrorOf([&] { LoadVerifiers(AssetsDir() / "models/shipped.net", "ppf"); }),
              HasSubstr("it is not a file of verifiers"));
  const std::string bytes = ReadFileBytes(file_);
  for (const double share : {0.0, 0.3, 0.9}) {
    const auto cut = temporary_->Write("cut.net", bytes.substr(0, size_t(share * bytes.size())));
    EXPECT_THAT(ErrorOf([&] { LoadVerifiers(cut, "ppf"); }), HasSubstr("cut.net")) << share;
  }
}

TEST_F(VerifiedPpf, StoppedTrainingKeepsFinishedVerifiers) {
  auto second = std::make_shared<ObjectModel>(*views_->objects()[0]);
  second->name = "second";
  FloatingInstances views({views_->objects()[0], second});
  const auto straight_file = temporary_->path() / "straight.net";
  const auto file = temporary_->path() / "stopped.net";
  VerifierJob job{views, "ppf", Job(file).candidates, straight_file, false, "test sensor", {}};
  EXPECT_TRUE(TrainVerifierLibrary(job, MinimalTraining()).finished);

  job.file = file;
  job.on_progress = [](std::string_view, double) { return false; };
  EXPECT_EQ(TrainVerifierLibrary(job, MinimalTraining()).saved, "");
  EXPECT_FALSE(std::filesystem::exists(file));
  job.on_progress = [](std::string_view object, double) { return object != "second"; };
  const VerifierReport stopped = TrainVerifierLibrary(job, MinimalTraining());
  EXPECT_FALSE(stopped.finished);
  EXPECT_EQ(stopped.saved, UnfinishedLibrary(file));
  EXPECT_EQ(stopped.saved_objects, 1);
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(LoadVerifiers(stopped.saved, "ppf").objects.size(), 1u);

  job.resume = true;
  job.on_progress = [](std::string_view object, double) { return object == "second"; };
  EXPECT_TRUE(TrainVerifierLibrary(job, MinimalTraining()).finished)
      << "the first verifier was trained again";
  EXPECT_FALSE(std::filesystem::exists(UnfinishedLibrary(file)));
  EXPECT_EQ(VerifierValues(LoadVerifiers(file, "ppf").verifiers),
            VerifierValues(LoadVerifiers(straight_file, "ppf").verifiers));

  VerifierTrainingOptions other = MinimalTraining();
  other.clutter_scenes += 1;
  EXPECT_THAT(ErrorOf([&] { TrainVerifierLibrary(job, other); }),
              testing::AllOf(HasSubstr("stopped.net"), HasSubstr("other settings")));
  FloatingInstances noisier({views_->objects()[0], second}, 0.001);
  const VerifierJob elsewhere{noisier, "ppf", job.candidates, file, true, "test sensor", {}};
  EXPECT_THAT(ErrorOf([&] { TrainVerifierLibrary(elsewhere, MinimalTraining()); }),
              testing::AllOf(HasSubstr("stopped.net"), HasSubstr("another bin")));
}

// A new training that is stopped keeps the file of the previous training, and resumes from its own
// state.
TEST_F(VerifiedPpf, PreviousFileStaysUntilTrainingFinishes) {
  auto second = std::make_shared<ObjectModel>(*views_->objects()[0]);
  second->name = "second";
  FloatingInstances views({views_->objects()[0], second});
  const auto file = temporary_->path() / "twice.net";
  std::filesystem::copy_file(file_, file);
  const std::string before = ReadFileBytes(file);
  VerifierTrainingOptions other = MinimalTraining();
  other.seed = 5;
  VerifierJob job{views, "ppf", Job(file).candidates, file, false, "test sensor", {}};
  job.on_progress = [](std::string_view object, double) { return object != "second"; };
  EXPECT_FALSE(TrainVerifierLibrary(job, other).finished);
  EXPECT_EQ(ReadFileBytes(file), before);
  job.resume = true;
  job.on_progress = {};
  EXPECT_TRUE(TrainVerifierLibrary(job, other).finished);
  EXPECT_EQ(LoadVerifiers(file, "ppf").objects.size(), 2u);
}

TEST_F(VerifiedPpf, UnknownModeIsRefused) {
  EstimatorSetup setup = MakeSetup();
  setup.spec.mode = "verifed";
  EXPECT_THAT(ErrorOf([&] { MakeEstimator(setup); }), HasSubstr("did you mean 'verified'"));
  setup.spec.mode = "accurate";
  EXPECT_TRUE(MakePpfTraining()->ModelFile(setup.spec).empty()) << "this mode reads no model";
}

}  // namespace
}  // namespace pickbed::tests
