#include "perception/training/verifier_training.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/base/error.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// Finds the true pose of each instance, or a shifted pose for a share of the instances.
class Shifted : public CandidateSource {
 public:
  Shifted(const ObjectSet& objects, const std::vector<LabelledView>& clutter_scenes, double shift_m,
          double share = 1, float cue = 5)
      : candidate_refiner_(objects, {}),
        clutter_scenes_(clutter_scenes),
        shift_m_(shift_m),
        share_(share),
        cue_(cue) {}

  std::vector<Candidate> Find(const OrganizedCloud&, Rng& rng, StageSeconds&,
                              EstimateTrace*) const override {
    std::vector<Candidate> found;
    for (const LabelledInstance& instance :
         clutter_scenes_[next_++ % clutter_scenes_.size()].instances) {
      Candidate& candidate = found.emplace_back();
      const double shift_m = rng.Uniform() < share_ ? shift_m_ : 0;
      candidate.hypothesis.X_CO = Translation({shift_m, 0, 0}) * instance.X_CO;
      for (float& feature : candidate.features) feature = static_cast<float>(rng.Normal());
      candidate.features[0] += shift_m > 0 ? -cue_ : cue_;
    }
    return found;
  }
  const CandidateRefiner& candidate_refiner() const override { return candidate_refiner_; }

 private:
  CandidateRefiner candidate_refiner_;
  const std::vector<LabelledView>& clutter_scenes_;
  double shift_m_, share_;
  float cue_;  // how strongly feature 0 separates right from wrong
  mutable size_t next_ = 0;
};

// A view of each of many rooms teaches more than many views of few rooms.
TEST(VerifierScenes, RoomsHaveOneViewEach) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.clutter_scenes = 2;
  options.views_per_scene = 3;
  options.room_scenes = 4;
  const auto set =
      VerifierScenes(views, ObjectId{0}, /*color=*/false, options, [](double) { return true; });
  EXPECT_EQ(set.clutter_scenes.size(), 6);
  EXPECT_EQ(set.rooms.size(), 4);
}

// A source of only right poses cannot train a verifier, and neither can a source of only wrong
// poses.
TEST(TrainObjectVerifier, LearnsFromTheCandidatesOfAllSources) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.clutter_scenes = 6;
  options.room_scenes = 0;
  options.verifier.iterations = 200;
  const auto go_on = [](double) { return true; };
  const auto set = VerifierScenes(views, ObjectId{0}, /*color=*/false, options, go_on);
  const auto& clutter_scenes = set.clutter_scenes;
  const Shifted right(views.objects(), clutter_scenes, 0),
      wrong(views.objects(), clutter_scenes, 0.05);
  const auto train = [&](std::vector<const CandidateSource*> sources) {
    return TrainObjectVerifier(set, ObjectId{0}, sources, options, go_on);
  };
  EXPECT_THROW(train({&right}), InputError);
  EXPECT_THROW(train({&wrong}), InputError);
  EXPECT_GT(train({&right, &wrong}).auc, 0.99);
}

// For equal features, a mode that is seldom right has lower scores than one that is often right.
TEST(TrainObjectVerifier, CalibratesEachModeByItsOwnCandidates) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.clutter_scenes = 20;
  options.room_scenes = 0;
  options.verifier.iterations = 200;
  const auto go_on = [](double) { return true; };
  const auto set = VerifierScenes(views, ObjectId{0}, /*color=*/false, options, go_on);
  const auto& clutter_scenes = set.clutter_scenes;
  const Shifted often(views.objects(), clutter_scenes, 0.05, 0.2, 0.5f);
  const Shifted seldom(views.objects(), clutter_scenes, 0.05, 0.8, 0.5f);
  const std::vector<const CandidateSource*> sources{&often, &seldom};
  const Verifier verifier = TrainObjectVerifier(set, ObjectId{0}, sources, options, go_on).verifier;
  const VerifyFeatures features{};
  EXPECT_GT(verifier.Score(features, CandidateMode::kAccurate), 0.6);
  EXPECT_LT(verifier.Score(features, CandidateMode::kFast), 0.4);
}

// Finds the true poses and shifted ones. Feature 0 separates them, in images without a known
// background with the opposite sign.
class SignByBackground : public CandidateSource {
 public:
  explicit SignByBackground(const ObjectSet& objects,
                            const std::vector<LabelledInstance>& instances)
      : candidate_refiner_(objects, {}), instances_(instances) {}

  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng, StageSeconds&,
                              EstimateTrace*) const override {
    const float sign = cloud.background == BackgroundKind::kKnown ? 1.0f : -1.0f;
    std::vector<Candidate> found;
    for (int i = 0; i < 20; ++i) {
      const LabelledInstance& instance = instances_[i % instances_.size()];
      Candidate& candidate = found.emplace_back();
      const double shift_m = i % 2 == 0 ? 0.05 : 0;
      candidate.hypothesis.X_CO = Translation({shift_m, 0, 0}) * instance.X_CO;
      for (float& feature : candidate.features) feature = static_cast<float>(rng.Normal());
      candidate.features[0] += sign * (shift_m > 0 ? -3.0f : 3.0f);
    }
    return found;
  }
  const CandidateRefiner& candidate_refiner() const override { return candidate_refiner_; }

 private:
  CandidateRefiner candidate_refiner_;
  std::vector<LabelledInstance> instances_;
};

// Images without a known background have a network of their own, and rooms without a right pose do
// not change it.
TEST(TrainObjectVerifier, LearnsUnknownBackgroundsFromRooms) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.clutter_scenes = options.room_scenes = 6;
  options.views_per_scene = 1;
  options.verifier.iterations = 200;
  const auto go_on = [](double) { return true; };
  const LabelledView view = views.ClutterScene({1, 1, ObjectId{0}}).front();
  VerifierTrainingSet set;
  set.clutter_scenes.assign(6, view);
  KnownBackground background;
  background.bin.inner_size_m = {5, 5, 5};
  background.X_CB = Translation({0, 0, -1});
  for (LabelledView& known : set.clutter_scenes) known.background = background;
  const SignByBackground source(views.objects(), view.instances);
  const std::vector<const CandidateSource*> sources{&source};
  const auto train = [&] {
    return TrainObjectVerifier(set, ObjectId{0}, sources, options, go_on).verifier;
  };
  VerifyFeatures high{};
  high[0] = 3;
  const Verifier without = train();
  EXPECT_GT(without.Score(high), 0.8);
  EXPECT_EQ(without.Score(high, CandidateMode::kFast, BackgroundKind::kNone),
            without.Score(high, CandidateMode::kFast));
  set.rooms.assign(6, view);
  const Verifier with = train();
  EXPECT_EQ(with.Score(high), without.Score(high));
  EXPECT_LT(std::min(with.Score(high, CandidateMode::kAccurate, BackgroundKind::kNone),
                     with.Score(high, CandidateMode::kAccurate, BackgroundKind::kFitted)),
            0.2);
  for (LabelledView& room : set.rooms) room.instances.clear();
  EXPECT_EQ(train().Score(high, CandidateMode::kAccurate, BackgroundKind::kNone),
            without.Score(high));
}

// Without clutter scenes, what is known about given backgrounds is kept.
TEST(TrainObjectVerifier, KeepsTheKnownNetwork) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.verifier.iterations = 200;
  const auto go_on = [](double) { return true; };
  const LabelledView view = views.ClutterScene({1, 1, ObjectId{0}}).front();
  VerifierTrainingSet set;
  set.rooms.assign(6, view);
  const SignByBackground source(views.objects(), view.instances);
  const std::vector<const CandidateSource*> sources{&source};
  TrainedVerifier start;
  start.auc = 0.75;
  start.verifier.known.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
  start.verifier.known.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  start.verifier.known.w1 = Eigen::MatrixXf::Zero(1, kVerifyFeatures);
  start.verifier.known.b1 = start.verifier.known.w2 = Eigen::VectorXf::Zero(1);
  start.verifier.known.b2 = 0.7f;
  start.verifier.unknown = start.verifier.known;
  EXPECT_THROW(TrainObjectVerifier(set, ObjectId{0}, sources, options, go_on), InputError);
  const TrainedVerifier kept =
      TrainObjectVerifier(set, ObjectId{0}, sources, options, go_on, &start);
  EXPECT_EQ(kept.auc, 0.75);
  EXPECT_EQ(kept.verifier.Score({}), start.verifier.Score({}));
  VerifyFeatures low{};
  low[0] = -3;
  EXPECT_GT(std::max(kept.verifier.Score(low, CandidateMode::kAccurate, BackgroundKind::kNone),
                     kept.verifier.Score(low, CandidateMode::kAccurate, BackgroundKind::kFitted)),
            0.7);
}

// Finds true and shifted poses with features that say nothing.
class Uninformed : public CandidateSource {
 public:
  Uninformed(const ObjectSet& objects, const std::vector<LabelledInstance>& instances)
      : candidate_refiner_(objects, {}), instances_(instances) {}

  std::vector<Candidate> Find(const OrganizedCloud&, Rng& rng, StageSeconds&,
                              EstimateTrace*) const override {
    std::vector<Candidate> found;
    for (int i = 0; i < 8; ++i) {
      Candidate& candidate = found.emplace_back();
      const double shift_m = i % 2 == 0 ? 0.05 : 0;
      candidate.hypothesis.X_CO =
          Translation({shift_m, 0, 0}) * instances_[i % instances_.size()].X_CO;
      for (float& feature : candidate.features) feature = static_cast<float>(rng.Normal());
    }
    return found;
  }
  const CandidateRefiner& candidate_refiner() const override { return candidate_refiner_; }

 private:
  CandidateRefiner candidate_refiner_;
  std::vector<LabelledInstance> instances_;
};

// The network learns its few examples by heart. Scores from networks that have not seen the scene
// show that it knows nothing.
TEST(TrainObjectVerifier, CrossFittingCorrectsAnOverfittedNetwork) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.views_per_scene = 1;
  options.verifier.networks = 1;  // the mean of several overfits less
  options.verifier.iterations = 200;
  const LabelledView view = views.ClutterScene({1, 1, ObjectId{0}}).front();
  VerifierTrainingSet set;
  set.clutter_scenes.assign(12, view);
  set.rooms.assign(24, view);
  const Uninformed source(views.objects(), view.instances);
  const std::vector<const CandidateSource*> sources{&source};
  const Verifier verifier =
      TrainObjectVerifier(set, ObjectId{0}, sources, options, [](double) { return true; }).verifier;
  Rng rng(9);
  double overconfident = 0, sum = 0;
  constexpr int kSamples = 200;
  for (int i = 0; i < kSamples; ++i) {
    VerifyFeatures features;
    for (float& feature : features) feature = static_cast<float>(rng.Normal());
    const double uncalibrated = 1 / (1 + std::exp(-verifier.unknown.Logit(features)));
    overconfident += std::abs(uncalibrated - 0.5);
    const auto doubt = [&](BackgroundKind kind) {
      return std::abs(verifier.Score(features, CandidateMode::kAccurate, kind) - 0.5);
    };
    // All rooms have the same background; the other calibration is the identity.
    sum += std::min(doubt(BackgroundKind::kFitted), doubt(BackgroundKind::kNone));
  }
  EXPECT_GT(overconfident / kSamples, 0.25);
  EXPECT_LT(sum, 0.75 * overconfident);
}

// A network that is sure of each pose, where half of the poses are wrong.
TEST(TrainObjectVerifier, ASharedNetworkTakesPartAndIsCalibrated) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.views_per_scene = 1;
  options.verifier.iterations = 50;
  VerifierNetwork sure;
  sure.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
  sure.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  sure.w1 = Eigen::MatrixXf::Zero(1, kVerifyFeatures);
  sure.b1 = sure.w2 = Eigen::VectorXf::Zero(1);
  sure.b2 = 12;
  options.shared_network = sure;
  const LabelledView view = views.ClutterScene({1, 1, ObjectId{0}}).front();
  VerifierTrainingSet set;
  set.clutter_scenes.assign(6, view);
  set.rooms.assign(24, view);
  const Uninformed source(views.objects(), view.instances);
  const std::vector<const CandidateSource*> sources{&source};
  const auto train = [&] {
    const auto go_on = [](double) { return true; };
    return TrainObjectVerifier(set, ObjectId{0}, sources, options, go_on).verifier;
  };
  const auto lowest_score = [](const Verifier& verifier) {
    // All rooms have the same background; the other calibration is the identity.
    return std::min(verifier.Score({}, CandidateMode::kAccurate, BackgroundKind::kFitted),
                    verifier.Score({}, CandidateMode::kAccurate, BackgroundKind::kNone));
  };
  const Verifier half_right = train();
  options.shared_network.reset();
  const float own_logit = train().unknown.Logit({});
  options.shared_network = sure;
  const float logit = half_right.unknown.Logit({});
  EXPECT_NEAR(logit, 0.5f * (own_logit + sure.b2), 1e-4);
  EXPECT_LT(lowest_score(half_right), 1 / (1 + std::exp(-logit)) - 0.1);
  for (LabelledView& room : set.rooms) room.instances.clear();
  const Verifier none_right = train();
  EXPECT_EQ(none_right.unknown.Logit({}), sure.b2) << "the object cannot teach a network";
  EXPECT_LT(lowest_score(none_right), lowest_score(half_right) - 0.1);
}

// A training that ran out of time has four rooms.
TEST(TrainObjectVerifier, FourRoomsGiveACalibration) {
  RayCastViews views({ObjectOf(BracketMesh())});
  VerifierTrainingOptions options;
  options.views_per_scene = 1;
  options.verifier.iterations = 50;
  const LabelledView view = views.ClutterScene({1, 1, ObjectId{0}}).front();
  VerifierTrainingSet set;
  set.clutter_scenes.assign(4, view);
  set.rooms.assign(4, view);
  const Uninformed source(views.objects(), view.instances);
  const std::vector<const CandidateSource*> sources{&source};
  const Verifier verifier =
      TrainObjectVerifier(set, ObjectId{0}, sources, options, [](double) { return true; }).verifier;
  const auto scale = [&](BackgroundKind kind) {
    return verifier.calibrations[static_cast<size_t>(kind)][0].scale;
  };
  EXPECT_TRUE(scale(BackgroundKind::kFitted) != 1 || scale(BackgroundKind::kNone) != 1);
}

TEST(AreaUnderRoc, CountsOrderedPairs) {
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.2, 0.8, 0.9}, {0, 0, 1, 1}), 1.0);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.2, 0.8, 0.9}, {1, 1, 0, 0}), 0.0);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.5, 0.5, 0.5}, {0, 1, 0}), 0.5);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.4, 0.3, 0.8}, {0, 0, 1, 1}), 0.75);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.2}, {1, 1}), 0.5);
}

}  // namespace
}  // namespace pickbed::tests
