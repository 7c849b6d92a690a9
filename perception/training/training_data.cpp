#include "perception/training/training_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Pose distance of two different objects: beyond all thresholds.
constexpr float kOtherObjectDistance = 10.0f;

}  // namespace

TrainingData::TrainingData(const ObjectSet& objects, std::vector<ObjectId> main_objects,
                           const std::vector<double>& sides_m, bool targets,
                           const TrainingOptions& options)
    : objects_(objects),
      main_objects_(std::move(main_objects)),
      options_(options),
      pairs_(objects.size()) {
  for (const auto& object : objects) embeddings_.emplace_back(*object);
  for (size_t object = 0; targets && object < objects.size(); ++object) {
    targets_.emplace_back(*objects[object], sides_m[object]);
    variants_ = std::max(variants_, targets_.back().variants());
  }
}

void TrainingData::Add(const std::vector<PatchPairs>& clutter_scene) {
  for (size_t object = 0; object < clutter_scene.size(); ++object) {
    AppendAll(clutter_scene[object].anchors, pairs_[object].anchors);
    AppendAll(clutter_scene[object].codes, pairs_[object].codes);
  }
  ++clutter_scenes_;
}

void TrainingData::RequireAllObjects() const {
  for (size_t object = 0; object < pairs_.size(); ++object) {
    CheckInput(pairs_[object].size() > 0,
               fmt::format("object '{}' was never visible enough in {} training scenes; raise "
                           "clutter_scenes (or the time limit) or lower positive_pairs.min_visible",
                           objects_[object]->name, clutter_scenes_));
  }
}

std::vector<TrainingData::Choice> TrainingData::Choose(int iteration) const {
  Rng rng = Rng::Derive(options_.seed, iteration, "training/batch");
  std::vector<ObjectId> seen;
  for (size_t object = 0; object < pairs_.size(); ++object) {
    if (pairs_[object].size() > 0) seen.push_back(ObjectId(object));
  }
  if (seen.empty()) RequireAllObjects();
  // A main object without pairs is replaced by another object.
  ObjectId main = main_objects_[iteration % main_objects_.size()];
  if (pairs_[main].size() == 0) main = seen[iteration % seen.size()];
  std::vector<Choice> choices(options_.batch);
  for (int i = 0; i < options_.batch; ++i) {
    const bool of_main = i < options_.main_share * options_.batch;
    choices[i].object = of_main ? main : seen[rng.Index(static_cast<int>(seen.size()))];
    choices[i].pair = rng.Index(static_cast<int>(pairs_[choices[i].object].size()));
  }
  return choices;
}

void TrainingData::FillDistances(const std::vector<Choice>& choices, TrainingBatch& batch) const {
  const size_t count = choices.size();
  PoseEmbedding::Points codes(24, count), positives;
  for (size_t j = 0; j < count; ++j) {
    const Choice& choice = choices[j];
    codes.col(j) = embeddings_[choice.object].Embed(pairs_[choice.object].codes.X_PO[choice.pair]);
  }
  batch.pose_distance.assign(count * count, kOtherObjectDistance);
  for (size_t i = 0; i < count; ++i) {
    const Choice& choice = choices[i];
    embeddings_[choice.object].EmbedVariants(pairs_[choice.object].anchors.X_PO[choice.pair],
                                             positives);
    for (size_t j = 0; j < count; ++j) {
      if (choices[j].object != choice.object) continue;
      batch.pose_distance[i * count + j] =
          std::sqrt((positives.colwise() - codes.col(j)).colwise().squaredNorm().minCoeff());
    }
  }
}

// Objects with fewer symmetric poses than variants_ repeat theirs.
void TrainingData::FillTargets(const std::vector<Choice>& choices, TrainingBatch& batch) const {
  batch.variants = variants_;
  for (const bool codes : {false, true}) {
    for (const Choice& choice : choices) {
      const PatchPairs& pairs = pairs_[choice.object];
      const Pose& X_PO = (codes ? pairs.codes : pairs.anchors).X_PO[choice.pair];
      const PoseTargets& targets = targets_[choice.object];
      batch.objects.push_back(choice.object);
      const size_t wanted = batch.rotations.size() + 4 * static_cast<size_t>(variants_);
      while (batch.rotations.size() < wanted) targets.AppendRotations(X_PO, batch.rotations);
      batch.rotations.resize(wanted);
      const Eigen::Vector3f center = targets.Center(X_PO);
      batch.centers.insert(batch.centers.end(), center.begin(), center.end());
    }
  }
}

TrainingBatch TrainingData::Batch(int iteration) const {
  const std::vector<Choice> choices = Choose(iteration);
  TrainingBatch batch;
  batch.count = options_.batch;
  for (const Choice& choice : choices) {
    const auto anchor = pairs_[choice.object].anchors.patch(choice.pair);
    const auto code = pairs_[choice.object].codes.patch(choice.pair);
    batch.anchors.insert(batch.anchors.end(), anchor.begin(), anchor.end());
    batch.codes.insert(batch.codes.end(), code.begin(), code.end());
  }
  FillDistances(choices, batch);
  if (!targets_.empty()) FillTargets(choices, batch);
  return batch;
}

}  // namespace pickbed::perception
