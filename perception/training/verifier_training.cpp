#include "perception/training/verifier_training.h"

#include <algorithm>
#include <cmath>

#include "perception/candidates/pose_selection.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr double kNoScore = 0;  // calibration uses poses of any score

// Returns the views of a codebook for these clutter scenes. Their distances cover the central 90 %
// of the object's distances.
IsolatedOptions CodeViews(const std::vector<LabelledView>& views, ObjectId object, int entries) {
  std::vector<double> distances_m;
  for (const LabelledView& view : views) {
    for (const LabelledInstance& instance : view.instances) {
      if (instance.object == object) distances_m.push_back(instance.X_CO.translation().norm());
    }
  }
  CheckInput(!distances_m.empty(), "no clutter scene for the verifier shows the object");
  std::sort(distances_m.begin(), distances_m.end());
  const double low_m = distances_m[distances_m.size() / 20];
  const double high_m = distances_m[distances_m.size() - 1 - distances_m.size() / 20];
  IsolatedOptions options;
  options.views = std::max(1, entries / options.patches_per_view);
  options.focal_px = views.front().frame.intrinsics.fx();
  options.distance_m = 0.5 * (low_m + high_m);
  options.distance_spread = std::clamp((high_m - low_m) / (high_m + low_m), 0.02, 0.5);
  return options;
}

// Labels poses, given by decreasing score. Each instance makes at most one pose right.
std::vector<ScoredPose> Judge(const std::vector<PoseHypothesis>& poses, const LabelledView& view,
                              ObjectId object, const PoseDistance& distance) {
  std::vector<bool> taken(view.instances.size());
  std::vector<ScoredPose> judged;
  for (const PoseHypothesis& pose : poses) {
    const double p = std::clamp(pose.score, 1e-6, 1 - 1e-6);
    ScoredPose& scored = judged.emplace_back();
    scored.logit = std::log(p / (1 - p));
    for (size_t i = 0; i < view.instances.size() && !scored.right; ++i) {
      const LabelledInstance& instance = view.instances[i];
      if (taken[i] || instance.object != object) continue;
      if (distance(pose.X_CO, instance.X_CO) >= kCorrectDiameters) continue;
      taken[i] = scored.right = true;
    }
  }
  return judged;
}

bool IsRight(const Pose& X_CO, const LabelledView& view, ObjectId object,
             const PoseDistance& distance) {
  return std::any_of(
      view.instances.begin(), view.instances.end(), [&](const LabelledInstance& instance) {
        return instance.object == object && distance(X_CO, instance.X_CO) < kCorrectDiameters;
      });
}

}  // namespace

void VerifierTrainingOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "random seed of clutter scenes and weights");
  v.RenamedKey("piles", "clutter_scenes");
  v.Integer("clutter_scenes", clutter_scenes, {1, 100000}, "number of clutter scenes per object");
  v.RenamedKey("views_per_pile", "views_per_scene");
  v.Integer("views_per_scene", views_per_scene, {1, 100}, "number of views of each clutter scene");
  v.Real("calibration_share", calibration_share, {0, 0.9},
         "share of the views, at their end, that is used for calibration");
  v.Group(
      "verifier", [&](SettingsVisitor& g) { verifier.Visit(g); }, "fit of the verifier");
}

Calibration Calibrate(const std::vector<ScoredPose>& poses) {
  constexpr double kPrior = 2;  // strength of the prior towards scale 1, shift 0, in poses
  constexpr int kSteps = 30;
  constexpr double kMinScale = 0.2;   // positive, so that the order of scores is kept
  const Eigen::Vector2d start(1, 0);  // scale, shift
  const auto loss = [&](const Eigen::Vector2d& x) {
    double sum = 0.5 * kPrior * (x - start).squaredNorm();
    for (const ScoredPose& pose : poses) {
      const double z = (pose.right ? -1 : 1) * (x[0] * pose.logit + x[1]);
      sum += std::max(z, 0.0) + std::log1p(std::exp(-std::abs(z)));
    }
    return sum;
  };
  Eigen::Vector2d x = start;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Vector2d gradient = kPrior * (x - start);
    Eigen::Matrix2d hessian = kPrior * Eigen::Matrix2d::Identity();
    for (const ScoredPose& pose : poses) {
      const Eigen::Vector2d input(pose.logit, 1);
      const double p = 1 / (1 + std::exp(-x.dot(input)));
      gradient += (p - pose.right) * input;
      hessian += p * (1 - p) * input * input.transpose();
    }
    // If the logits are nearly equal, full Newton steps overshoot.
    const Eigen::Vector2d full = hessian.ldlt().solve(gradient);
    const double before = loss(x);
    double share = 1;
    while (share > 1e-6 && loss(x - share * full) > before) share *= 0.5;
    x -= share * full;
    x[0] = std::max(x[0], kMinScale);
  }
  return {static_cast<float>(x[0]), static_cast<float>(x[1])};
}

namespace {

// With a time limit, the smallest number of clutter scenes, and of views of them.
constexpr int kMinScenes = 4;

bool IsPast(VerifierDeadlines::Time time) { return std::chrono::steady_clock::now() > time; }

}  // namespace

std::vector<LabelledView> VerifierScenes(LabelledViewSource& views, ObjectId object, bool color,
                                         const VerifierTrainingOptions& options,
                                         const std::function<bool(double)>& on_share) {
  CheckSettings("VerifierTrainingOptions", options);
  std::vector<LabelledView> all;
  for (int i = 0; i < options.clutter_scenes; ++i) {
    Rng rng = Rng::Derive(options.seed, i, "training/verifier_pile");
    ClutterSceneRequest request{rng.Next(), options.views_per_scene, object, true};
    for (LabelledView& view : views.ClutterScene(request)) {
      // The colour image takes a third of the memory.
      if (!color) view.frame.color = {};
      all.push_back(std::move(view));
    }
    if (!on_share(static_cast<double>(i + 1) / options.clutter_scenes)) break;
    if (i + 1 >= kMinScenes && options.deadlines && IsPast(options.deadlines->views)) break;
  }
  return all;
}

VerifierTrainingSet MakeVerifierTrainingSet(LabelledViewSource& views, ObjectId object,
                                            const PatchForm& form,
                                            const VerifierTrainingOptions& options,
                                            const std::function<bool(double)>& on_share) {
  CheckSettings("VerifierTrainingOptions", options);
  constexpr double kScenesShare = 0.8;  // approximate share of the time
  VerifierTrainingSet training_set;
  bool go_on = true;
  training_set.clutter_scenes =
      VerifierScenes(views, object, form.channels == PatchChannels::kDepthColor, options,
                     [&](double share) { return go_on = on_share(kScenesShare * share); });
  if (!go_on) return training_set;
  ForEachIsolatedBlock(views, object, form,
                       CodeViews(training_set.clutter_scenes, object, options.entries),
                       options.seed, [&](const LabelledPatches& patches, double share) {
                         AppendAll(patches, training_set.codes);
                         return on_share(kScenesShare + (1 - kScenesShare) * share);
                       });
  return training_set;
}

TrainedVerifier TrainObjectVerifier(const VerifierTrainingSet& training_set,
                                    const std::shared_ptr<const ObjectModel>& model,
                                    const VerifierObject& wanted,
                                    const VerifierTrainingOptions& options,
                                    const std::function<bool(double)>& on_share) {
  ObjectCodes codes;
  codes.length = wanted.descriptor_length;
  AppendCodes(training_set.codes, wanted.voter.describe, codes);
  std::vector<std::unique_ptr<CandidateFinder>> finders;
  std::vector<const CandidateSource*> sources;
  for (const CandidateOptions& mode : options.candidates) {
    finders.push_back(std::make_unique<CandidateFinder>(
        std::vector<CandidateObject>{{model, wanted.side_m, codes, wanted.object}}, wanted.voter,
        mode));
    sources.push_back(finders.back().get());
  }
  return TrainObjectVerifier(training_set.clutter_scenes, wanted.object, sources, options,
                             on_share);
}

TrainedVerifier TrainObjectVerifier(const std::vector<LabelledView>& clutter_scenes,
                                    ObjectId object,
                                    std::span<const CandidateSource* const> sources,
                                    const VerifierTrainingOptions& options,
                                    const std::function<bool(double)>& on_share) {
  CheckSettings("VerifierTrainingOptions", options);
  const CandidateRefiner& candidate_refiner = sources.front()->candidate_refiner();
  const std::vector<PoseDistance>& distances = candidate_refiner.distances();
  VerifierExamples examples;
  std::vector<std::vector<std::vector<Candidate>>> found(
      clutter_scenes.size());  // by view and source
  StageSeconds seconds;
  size_t count = clutter_scenes.size();  // views that are used
  std::vector<size_t> examples_until;    // number of examples after each view
  for (size_t i = 0; i < count; ++i) {
    if (!on_share(static_cast<double>(i) / count)) return {};
    Rng rng = Rng::Derive(options.seed, i, "training/verifier_view");
    const OrganizedCloud cloud = BuildCloud(clutter_scenes[i].frame, clutter_scenes[i].background);
    for (const CandidateSource* source : sources) {
      for (const Candidate& candidate : found[i].emplace_back(source->Find(cloud, rng, seconds))) {
        examples.features.push_back(candidate.features);
        examples.right.push_back(
            IsRight(candidate.hypothesis.X_CO, clutter_scenes[i], object, distances.front()));
      }
    }
    examples_until.push_back(examples.features.size());
    const bool is_enough =
        i + 1 >= static_cast<size_t>(kMinScenes) * options.views_per_scene || i + 1 == count;
    if (is_enough && options.deadlines && IsPast(options.deadlines->candidates)) count = i + 1;
  }
  const size_t learned = count - static_cast<size_t>(options.calibration_share * count);
  if (learned > 0) examples.held_out_from = examples_until[learned - 1];
  TrainedVerifier trained = TrainVerifier(examples, options.verifier, options.seed);
  std::vector<std::vector<ScoredPose>> reported(sources.size());
  for (size_t i = learned; i < count; ++i) {
    const OrganizedCloud cloud = BuildCloud(clutter_scenes[i].frame, clutter_scenes[i].background);
    for (size_t s = 0; s < sources.size(); ++s) {
      PoseSelectionOptions all;
      all.min_score = kNoScore;
      const auto set = SelectPoses(cloud, candidate_refiner.model_points(), distances,
                                   {&trained.verifier, 1}, found[i][s], all);
      const auto judged = Judge(set, clutter_scenes[i], object, distances.front());
      reported[s].insert(reported[s].end(), judged.begin(), judged.end());
    }
  }
  auto& calibrations = trained.verifier.calibrations;
  for (size_t mode = 0; mode < calibrations.size(); ++mode) {
    calibrations[mode] = mode < sources.size() ? Calibrate(reported[mode]) : calibrations[0];
  }
  return trained;
}

}  // namespace pickbed::perception
