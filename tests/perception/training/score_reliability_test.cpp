#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "perception/training/verifier_training.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

constexpr std::array kBackgrounds{BackgroundKind::kKnown, BackgroundKind::kFitted,
                                  BackgroundKind::kNone};
constexpr float kCue = 0.9f;  // mean of feature 0 of right poses; -kCue of wrong ones

// Share of right poses.
double ShareOf(BackgroundKind background) {
  switch (background) {
    case BackgroundKind::kKnown:
      return 0.6;
    case BackgroundKind::kFitted:
      return 0.35;
    default:
      return 0.15;
  }
}

VerifyFeatures FeaturesOf(bool is_right, Rng& rng) {
  VerifyFeatures features;
  for (float& feature : features) feature = static_cast<float>(rng.Normal());
  features[0] += is_right ? kCue : -kCue;
  return features;
}

// Probability that a pose with these features is right, by Bayes.
double Posterior(const VerifyFeatures& features, double share) {
  return 1 / (1 + (1 - share) / share * std::exp(-2 * kCue * features[0]));
}

// One pose per instance, right or rotated by half a turn.
class PosesByShare : public CandidateSource {
 public:
  PosesByShare(const ObjectSet& objects, std::vector<LabelledInstance> instances)
      : candidate_refiner_(objects, {}), instances_(std::move(instances)) {}

  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng, StageSeconds&,
                              EstimateTrace*) const override {
    std::vector<Candidate> found;
    for (const LabelledInstance& instance : instances_) {
      const bool is_right = rng.Uniform() < ShareOf(cloud.background);
      Pose turn = Pose::Identity();
      if (!is_right) turn.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
      Candidate& candidate = found.emplace_back();
      candidate.hypothesis.X_CO = instance.X_CO * turn;
      candidate.features = FeaturesOf(is_right, rng);
    }
    return found;
  }
  const CandidateRefiner& candidate_refiner() const override { return candidate_refiner_; }

 private:
  CandidateRefiner candidate_refiner_;
  std::vector<LabelledInstance> instances_;
};

// Three objects on a floor, each 46 px wide or more, so that no score is lowered (image_domain.h).
LabelledView ViewOfThree(const ObjectModel& object) {
  const CameraIntrinsics camera{320, 240, 360, 360, 159.5, 119.5};
  SyntheticDepth scene(camera);
  LabelledView view;
  scene.AddPlane(-Eigen::Vector3d::UnitZ(), {0, 0, 0.6});
  for (const double x_m : {-0.13, 0.0, 0.13}) {
    view.instances.push_back({ObjectId(0), Translation({x_m, 0, 0.52}), 1.0});
    scene.AddMesh(object.mesh_O, view.instances.back().X_CO);
  }
  view.frame = scene.frame();
  view.background = OutOfSightBin();
  return view;
}

// Expected calibration error over ten ranges of the score, for features of fresh poses. `scored`
// returns the score.
template <typename Scored>
double CalibrationError(BackgroundKind background, const Scored& scored) {
  constexpr int kPoses = 4000, kRanges = 10;
  Rng rng(17);
  std::array<double, kRanges> excess{};
  for (int i = 0; i < kPoses; ++i) {
    const double share = ShareOf(background);
    const VerifyFeatures features = FeaturesOf(rng.Uniform() < share, rng);
    const double score = scored(features);
    const int range = std::min(kRanges - 1, static_cast<int>(kRanges * score));
    excess[range] += score - Posterior(features, share);
  }
  double sum = 0;
  for (const double e : excess) sum += std::abs(e);
  return sum / kPoses;
}

// Poses are right with another share for each background. The score of each background is a
// probability. Scores raised to a power, or calibrated for another background, are not.
TEST(ScoreReliability, HoldsForEachBackground) {
  constexpr double kBound = 0.07;
  RayCastViews views({ObjectOf(BracketMesh())});
  const LabelledView view = ViewOfThree(*views.objects()[0]);
  VerifierTrainingOptions options;
  options.views_per_scene = 1;
  options.verifier.iterations = 300;
  options.verifier.hidden = 4;
  options.verifier.weight_decay = 0.01;
  VerifierTrainingSet set;
  set.clutter_scenes.assign(120, view);
  set.rooms.assign(180, view);  // in every third room, no planes are looked for
  const PosesByShare source(views.objects(), view.instances);
  const std::vector<const CandidateSource*> sources{&source};
  const Verifier verifier =
      TrainObjectVerifier(set, ObjectId{0}, sources, options, [](double) { return true; }).verifier;
  for (const BackgroundKind background : kBackgrounds) {
    SCOPED_TRACE(static_cast<int>(background));
    const auto error = [&](BackgroundKind calibrated_for, double power) {
      return CalibrationError(background, [&](const VerifyFeatures& features) {
        return std::pow(verifier.Score(features, CandidateMode::kAccurate, calibrated_for), power);
      });
    };
    EXPECT_LT(error(background, 1), kBound);
    EXPECT_GT(error(background, 3), kBound);
    EXPECT_GT(error(background, 1.0 / 3), kBound);
    for (const BackgroundKind other : kBackgrounds) {
      if (other == background) continue;
      EXPECT_GT(error(other, 1), kBound) << "calibrated for " << static_cast<int>(other);
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
