#include "perception/training/verifier_training.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "perception/candidates/pose_selection.h"
#include "perception/training/logit_calibration.h"
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
  v.Integer("clutter_scenes", clutter_scenes, {0, 100000}, "number of clutter scenes per object");
  v.Integer("room_scenes", room_scenes, {0, 100000},
            "number of rooms per object, of which every second has no object; 0 = no verifier for "
            "unknown backgrounds");
  v.RenamedKey("views_per_pile", "views_per_scene");
  v.Integer("views_per_scene", views_per_scene, {1, 100}, "number of views of each clutter scene");
  v.Real("calibration_share", calibration_share, {0, 0.9},
         "share of the views, at their end, that is used for calibration");
  v.Group(
      "verifier", [&](SettingsVisitor& g) { verifier.Visit(g); }, "fit of the verifier");
}

namespace {

constexpr int kMinScenes = 4;  // with a time limit, of each kind

constexpr int kViewsPerRoom = 1;  // many rooms teach more than many views of few rooms
constexpr size_t kRoomPair = 2;   // every second room has no object
constexpr size_t kFolds = 3;      // of the cross-fitting

// Whether a time limit leaves no time for one more step, if it takes as long as the steps so far.
class StepLimit {
 public:
  StepLimit(const TrainingClock& now, TrainingTime end) : now_(now), start_(now()), end_(end) {}
  bool IsOver(int steps_done) const {
    const TrainingTime now = now_();
    return Later(now, SecondsBetween(start_, now) / steps_done) > end_;
  }

 private:
  const TrainingClock& now_;
  TrainingTime start_, end_;
};

}  // namespace

VerifierTrainingSet VerifierScenes(LabelledViewSource& views, ObjectId object, bool color,
                                   const VerifierTrainingOptions& options,
                                   const std::function<bool(double)>& on_share) {
  CheckSettings("VerifierTrainingOptions", options);
  VerifierTrainingSet all;
  bool go_on = true;
  const double total = std::max(1, options.clutter_scenes + options.room_scenes);
  // Appends views of scenes 0, 1, ... until there are enough, or its share of the time that is left
  // is over.
  const auto append = [&](const char* stream, int scenes, int before, double time_share,
                          const auto& surroundings, std::vector<LabelledView>& to) {
    std::optional<StepLimit> limit;
    if (options.deadlines) {
      const TrainingTime now = options.deadlines->now();
      const double left_s = SecondsBetween(now, options.deadlines->views);
      limit.emplace(options.deadlines->now, Later(now, time_share * left_s));
    }
    for (int i = 0; i < scenes && go_on; ++i) {
      Rng rng = Rng::Derive(options.seed, i, stream);
      const Surroundings around = surroundings(i);
      const int count = around == Surroundings::kNone ? options.views_per_scene : kViewsPerRoom;
      const ClutterSceneRequest request{rng.Next(), count, object, true, around};
      for (LabelledView& view : views.ClutterScene(request)) {
        // The color image takes a third of the memory.
        if (!color) view.frame.color = {};
        to.push_back(std::move(view));
      }
      go_on = on_share((before + i + 1) / total);
      if (i + 1 >= kMinScenes && limit && limit->IsOver(i + 1)) break;
    }
  };
  const double clutter_share = options.clutter_scenes / total;
  append(
      "training/verifier_pile", options.clutter_scenes, 0, clutter_share,
      [](int) { return Surroundings::kNone; }, all.clutter_scenes);
  append(
      "training/verifier_room", options.room_scenes, options.clutter_scenes, 1,
      [](int i) {
        return i % 2 == 1   ? Surroundings::kEmptyRoom
               : i % 4 == 0 ? Surroundings::kRoomAndBin
                            : Surroundings::kRoomNoBin;
      },
      all.rooms);
  return all;
}

VerifierTrainingSet MakeVerifierTrainingSet(LabelledViewSource& views, ObjectId object,
                                            const PatchForm& form,
                                            const VerifierTrainingOptions& options,
                                            const std::function<bool(double)>& on_share) {
  constexpr double kScenesShare = 0.8;  // approximate share of the time
  bool go_on = true;
  VerifierTrainingSet training_set =
      VerifierScenes(views, object, form.channels == PatchChannels::kDepthColor, options,
                     [&](double share) { return go_on = on_share(kScenesShare * share); });
  if (!go_on) return training_set;
  const std::vector<LabelledView>& shown =
      training_set.clutter_scenes.empty() ? training_set.rooms : training_set.clutter_scenes;
  ForEachIsolatedBlock(views, object, form, CodeViews(shown, object, options.entries), options.seed,
                       [&](const LabelledPatches& patches, double share) {
                         AppendAll(patches, training_set.codes);
                         return on_share(kScenesShare + (1 - kScenesShare) * share);
                       });
  return training_set;
}

namespace {

// Sources of candidates from learned descriptors for one object, one per mode.
class DescriptorSources {
 public:
  DescriptorSources(const VerifierTrainingSet& training_set,
                    const std::shared_ptr<const ObjectModel>& model, const VerifierObject& wanted,
                    const VerifierTrainingOptions& options) {
    ObjectCodes codes;
    codes.length = wanted.descriptor_length;
    AppendCodes(training_set.codes, wanted.voter.describe, codes);
    for (const CandidateOptions& mode : options.candidates) {
      finders_.push_back(std::make_unique<CandidateFinder>(
          std::vector<CandidateObject>{{model, wanted.side_m, codes, wanted.object}}, wanted.voter,
          mode));
      sources_.push_back(finders_.back().get());
    }
  }
  std::span<const CandidateSource* const> get() const { return sources_; }

 private:
  std::vector<std::unique_ptr<CandidateFinder>> finders_;
  std::vector<const CandidateSource*> sources_;
};

// Trains and calibrates one network on some views.
class NetworkTrainer {
 public:
  NetworkTrainer(const std::vector<LabelledView>& views, bool is_known, ObjectId object,
                 std::span<const CandidateSource* const> sources,
                 const VerifierTrainingOptions& options)
      : views_(views),
        is_known_(is_known),
        object_(object),
        sources_(sources),
        refiner_(sources.front()->candidate_refiner()),
        options_(options) {}

  // Finds candidates in the views, until `end` if given. Returns false if stopped.
  bool Find(const std::function<bool(double)>& on_share, const std::optional<TrainingTime>& end);
  bool HasRight() const { return std::ranges::count(examples_.right, 1) > 0; }
  const VerifierExamples& examples() const { return examples_; }

  // Trains the network on the first views and calibrates it on the others.
  TrainedNetwork TrainKnown(Verifier& verifier) const;

  // Trains the network for unknown backgrounds on all views and calibrates it, also on all views:
  // the scores of a scene come from a network that did not learn from this scene (cross-fitting).
  // There are too few rooms to hold some of them out. A given network takes part with half of the
  // logit, or with all of it if no candidate is right.
  void TrainUnknown(Verifier& verifier) const;

 private:
  // A view that was searched for candidates.
  struct SearchedView {
    size_t view = 0;
    std::vector<std::vector<Candidate>> found;  // by source
  };

  // Poses of all scores, by background and mode.
  using Reported =
      std::array<std::array<std::vector<ScoredPose>, kCandidateModes>, kBackgroundKinds>;

  // Adds the poses that the uncalibrated verifier reports in a view.
  void Report(const Verifier& verifier, const SearchedView& searched, Reported& reported) const;

  // Calibrates the verifier for the backgrounds of the views.
  void CalibrateScores(const Reported& reported, Verifier& verifier) const;

  size_t FoldOf(size_t view) const;

  // Trains a network for unknown backgrounds, and lets the given one take part.
  VerifierNetwork NetworkFor(const VerifierExamples& examples) const;

  // Examples of the views that are not in a fold.
  VerifierExamples ExamplesWithout(size_t fold) const;

  // A third of the rooms is searched as if no plane had been found, so that walls and tables give
  // candidates, too. The shift after each six rooms spreads these rooms over all folds.
  OrganizedCloud CloudOf(size_t view) const {
    CloudOptions options;
    if (!is_known_ && (view + view / 6) % 3 == 2) options.min_plane_share = 1;
    return BuildCloud(views_[view].frame,
                      is_known_ ? views_[view].background : std::optional<KnownBackground>(),
                      options);
  }

  std::vector<size_t> SearchOrder(bool has_limit) const;

  // Adds the candidates of a view as examples.
  void AddExamples(const SearchedView& searched, VerifierExamples& examples) const;

  const std::vector<LabelledView>& views_;
  bool is_known_;
  ObjectId object_;
  std::span<const CandidateSource* const> sources_;
  const CandidateRefiner& refiner_;
  const VerifierTrainingOptions& options_;
  std::vector<SearchedView> searched_;  // by increasing view
  VerifierExamples examples_;           // of these views
  std::vector<size_t> examples_until_;  // number of examples after each of them
};

// With a time limit, the first views of all scenes come first: one view of each of many scenes
// teaches more than many views of one.
std::vector<size_t> NetworkTrainer::SearchOrder(bool has_limit) const {
  std::vector<size_t> order(views_.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto per_scene = static_cast<size_t>(is_known_ ? options_.views_per_scene : kViewsPerRoom);
  if (has_limit) {
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return a % per_scene < b % per_scene; });
  }
  return order;
}

void NetworkTrainer::AddExamples(const SearchedView& searched, VerifierExamples& examples) const {
  for (const std::vector<Candidate>& of_source : searched.found) {
    for (const Candidate& candidate : of_source) {
      examples.features.push_back(candidate.features);
      examples.right.push_back(IsRight(candidate.hypothesis.X_CO, views_[searched.view], object_,
                                       refiner_.distances().front()));
    }
  }
}

bool NetworkTrainer::Find(const std::function<bool(double)>& on_share,
                          const std::optional<TrainingTime>& end) {
  const char* stream = is_known_ ? "training/verifier_view" : "training/verifier_room_view";
  StageSeconds seconds;
  std::optional<StepLimit> limit;
  if (end) limit.emplace(options_.deadlines->now, *end);
  for (const size_t view : SearchOrder(limit.has_value())) {
    const auto done = static_cast<int>(searched_.size());
    if (!on_share(static_cast<double>(done) / static_cast<double>(views_.size()))) return false;
    if (limit && done >= kMinScenes && limit->IsOver(done)) break;
    Rng rng = Rng::Derive(options_.seed, view, stream);
    const OrganizedCloud cloud = CloudOf(view);
    SearchedView& searched = searched_.emplace_back(SearchedView{view, {}});
    for (const CandidateSource* source : sources_) {
      searched.found.push_back(source->Find(cloud, rng, seconds));
    }
  }
  std::ranges::sort(searched_, {}, &SearchedView::view);
  for (const SearchedView& searched : searched_) {
    AddExamples(searched, examples_);
    examples_until_.push_back(examples_.features.size());
  }
  return true;
}

TrainedNetwork NetworkTrainer::TrainKnown(Verifier& verifier) const {
  const size_t count = searched_.size();
  const size_t learned = count - static_cast<size_t>(options_.calibration_share * count);
  VerifierExamples examples = examples_;
  if (learned > 0) examples.held_out_from = examples_until_[learned - 1];
  const TrainedNetwork trained = TrainVerifier(examples, options_.verifier, options_.seed);
  verifier.known = verifier.unknown = trained.network;
  Reported reported;
  for (size_t i = learned; i < count; ++i) Report(verifier, searched_[i], reported);
  CalibrateScores(reported, verifier);
  return trained;
}

void NetworkTrainer::TrainUnknown(Verifier& verifier) const {
  for (size_t kind = 1; kind < kBackgroundKinds; ++kind) verifier.calibrations[kind] = {};
  Reported reported;
  if (!HasRight()) {
    verifier.unknown = *options_.shared_network;
    for (const SearchedView& searched : searched_) Report(verifier, searched, reported);
    return CalibrateScores(reported, verifier);
  }
  for (size_t fold = 0; fold < kFolds; ++fold) {
    const VerifierExamples others = ExamplesWithout(fold);
    const auto right = std::ranges::count(others.right, 1);
    if (right == 0 || right == static_cast<std::ptrdiff_t>(others.right.size())) continue;
    Verifier without = verifier;
    without.unknown = NetworkFor(others);
    for (const SearchedView& searched : searched_) {
      if (FoldOf(searched.view) == fold) Report(without, searched, reported);
    }
  }
  verifier.unknown = NetworkFor(examples_);
  CalibrateScores(reported, verifier);
}

VerifierNetwork NetworkTrainer::NetworkFor(const VerifierExamples& examples) const {
  VerifierNetwork own = TrainVerifier(examples, options_.verifier, options_.seed).network;
  return options_.shared_network ? MeanNetwork(own, *options_.shared_network) : own;
}

// A room is in one fold with the empty room that follows. So a training that ran out of time after
// four rooms still has two folds.
size_t NetworkTrainer::FoldOf(size_t view) const {
  return view / kViewsPerRoom / kRoomPair % kFolds;
}

VerifierExamples NetworkTrainer::ExamplesWithout(size_t fold) const {
  VerifierExamples others;
  for (const SearchedView& searched : searched_) {
    if (FoldOf(searched.view) != fold) AddExamples(searched, others);
  }
  return others;
}

void NetworkTrainer::Report(const Verifier& verifier, const SearchedView& searched,
                            Reported& reported) const {
  const OrganizedCloud cloud = CloudOf(searched.view);
  PoseSelectionOptions all;
  all.min_score = kNoScore;
  for (size_t s = 0; s < sources_.size(); ++s) {
    const auto set = SelectPoses(cloud, refiner_.model_points(), refiner_.distances(),
                                 {&verifier, 1}, searched.found[s], all);
    const auto judged = Judge(set, views_[searched.view], object_, refiner_.distances().front());
    const BackgroundKind kind = is_known_ ? BackgroundKind::kKnown : cloud.background;
    auto& poses = reported[static_cast<size_t>(kind)][s];
    poses.insert(poses.end(), judged.begin(), judged.end());
  }
}

void NetworkTrainer::CalibrateScores(const Reported& reported, Verifier& verifier) const {
  const auto known = static_cast<size_t>(BackgroundKind::kKnown);
  for (size_t kind = 0; kind < kBackgroundKinds; ++kind) {
    if ((kind == known) != is_known_) continue;
    auto& calibrations = verifier.calibrations[kind];
    for (size_t mode = 0; mode < calibrations.size(); ++mode) {
      calibrations[mode] =
          mode < sources_.size() ? Calibrate(reported[kind][mode]) : calibrations[0];
    }
  }
}

}  // namespace

TrainedVerifier TrainObjectVerifier(const VerifierTrainingSet& training_set, ObjectId object,
                                    std::span<const CandidateSource* const> sources,
                                    const VerifierTrainingOptions& options,
                                    const std::function<bool(double)>& on_share,
                                    const TrainedVerifier* start) {
  CheckSettings("VerifierTrainingOptions", options);
  const double scenes = static_cast<double>(training_set.clutter_scenes.size());
  const double clutter_share =
      scenes / std::max(1.0, scenes + static_cast<double>(training_set.rooms.size()));
  TrainedVerifier trained;
  std::optional<TrainingTime> end;
  if (options.deadlines) end = options.deadlines->end;
  if (training_set.clutter_scenes.empty()) {
    CheckInput(start != nullptr, "the verifier needs clutter scenes; raise clutter_scenes");
    trained = *start;
  } else {
    NetworkTrainer known(training_set.clutter_scenes, true, object, sources, options);
    std::optional<TrainingTime> clutter_end = end;
    if (end) {
      const TrainingTime now = options.deadlines->now();
      clutter_end = Later(now, clutter_share * SecondsBetween(now, *end));
    }
    if (!known.Find([&](double share) { return on_share(clutter_share * share); }, clutter_end)) {
      return {};
    }
    const TrainingTime fit_began = end ? options.deadlines->now() : TrainingTime();
    trained.auc = known.TrainKnown(trained.verifier).auc;
    if (end) {
      // The fits for unknown backgrounds, one per fold and one for all, take about as long each.
      const double fit_s = SecondsBetween(fit_began, options.deadlines->now());
      end = Later(*end, -fit_s * static_cast<double>(kFolds + 1));
    }
  }
  const auto& known_calibrations = trained.verifier.calibrations.front();
  NetworkTrainer unknown(training_set.rooms, false, object, sources, options);
  const auto on_second = [&](double share) {
    return on_share(clutter_share + (1 - clutter_share) * share);
  };
  if (!unknown.Find(on_second, end)) return {};
  if (training_set.rooms.empty() || (!unknown.HasRight() && !options.shared_network)) {
    trained.verifier.unknown = trained.verifier.known;
    trained.verifier.calibrations.fill(known_calibrations);
    return trained;
  }
  unknown.TrainUnknown(trained.verifier);
  return trained;
}

TrainedVerifier TrainObjectVerifier(const VerifierTrainingSet& training_set,
                                    const std::shared_ptr<const ObjectModel>& model,
                                    const VerifierObject& wanted,
                                    const VerifierTrainingOptions& options,
                                    const std::function<bool(double)>& on_share,
                                    const TrainedVerifier* start) {
  const DescriptorSources sources(training_set, model, wanted, options);
  return TrainObjectVerifier(training_set, wanted.object, sources.get(), options, on_share, start);
}

VerifierExamples RoomExamples(const VerifierTrainingSet& training_set,
                              const std::shared_ptr<const ObjectModel>& model,
                              const VerifierObject& wanted, const VerifierTrainingOptions& options,
                              const std::function<bool(double)>& on_share) {
  const DescriptorSources sources(training_set, model, wanted, options);
  NetworkTrainer rooms(training_set.rooms, false, wanted.object, sources.get(), options);
  if (!rooms.Find(on_share, std::nullopt)) return {};
  return rooms.examples();
}

}  // namespace pickbed::perception
