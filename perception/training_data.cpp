#include "perception/training_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/check.h"

namespace pickbed {
namespace {

// Pose distance of two different parts: beyond every threshold.
constexpr float kOtherPart = 10.0f;

}  // namespace

TrainingData::TrainingData(const ObjectSet& objects, std::vector<double> sides_m,
                           const TrainingOptions& options)
    : objects_(objects), sides_m_(std::move(sides_m)), options_(options), parts_(objects.size()) {
  for (const auto& object : objects) embeddings_.emplace_back(*object);
}

bool TrainingData::Collect(LabelledViewSource& views, const std::function<bool(double)>& on_share) {
  const int piles = options_.piles * static_cast<int>(objects_.size());
  std::vector<double> distances_m;
  CameraIntrinsics intrinsics;
  for (int i = 0; i < piles; ++i) {
    Rng rng = Rng::Derive(options_.seed, i, "training/pile");
    const std::vector<LabelledView> pile = views.Pile({rng.Next(), options_.views_per_pile});
    AppendTwinPatches(views, pile, sides_m_, options_.twins, rng, parts_);
    for (const LabelledView& view : pile) {
      intrinsics = view.frame.intrinsics;
      for (const LabelledInstance& instance : view.instances) {
        distances_m.push_back(instance.X_CO.translation().norm());
      }
    }
    if (!on_share(static_cast<double>(i + 1) / piles)) return false;
  }
  for (size_t p = 0; p < parts_.size(); ++p) {
    CheckInput(parts_[p].size() > 0,
               fmt::format("part '{}' was never seen well enough in {} training piles; raise "
                           "piles or lower twins.min_visible",
                           objects_[p]->name, piles));
  }
  SetCamera(intrinsics, std::move(distances_m));
  return true;
}

void TrainingData::SetCamera(const CameraIntrinsics& intrinsics, std::vector<double> distances_m) {
  // The middle 90 % of the distances.
  std::sort(distances_m.begin(), distances_m.end());
  const double low = distances_m[distances_m.size() / 20];
  const double high = distances_m[distances_m.size() - 1 - distances_m.size() / 20];
  camera_.focal_px = intrinsics.fx;
  camera_.distance_m = 0.5 * (low + high);
  camera_.distance_spread = std::clamp((high - low) / (high + low), 0.02, 0.5);
}

size_t TrainingData::size() const {
  size_t pairs = 0;
  for (const PatchPairs& part : parts_) pairs += part.size();
  return pairs;
}

std::vector<TrainingData::Choice> TrainingData::Choose(int iteration) const {
  Rng rng = Rng::Derive(options_.seed, iteration, "training/batch");
  const int part_count = static_cast<int>(parts_.size());
  std::vector<Choice> choices(options_.batch);
  for (int i = 0; i < options_.batch; ++i) {
    const bool of_main = i < options_.main_share * options_.batch;
    choices[i].part = of_main ? iteration % part_count : rng.Index(part_count);
    choices[i].pair = rng.Index(static_cast<int>(parts_[choices[i].part].size()));
  }
  return choices;
}

void TrainingData::FillDistances(const std::vector<Choice>& choices, TrainingBatch& batch) const {
  const size_t count = choices.size();
  Eigen::Matrix<float, 24, Eigen::Dynamic> codes(24, count);
  for (size_t j = 0; j < count; ++j) {
    const Choice& choice = choices[j];
    codes.col(j) = embeddings_[choice.part].Embed(parts_[choice.part].codes.X_PO[choice.pair]);
  }
  batch.pose_distance.assign(count * count, kOtherPart);
  for (size_t i = 0; i < count; ++i) {
    const Choice& choice = choices[i];
    const auto twins =
        embeddings_[choice.part].EmbedTwins(parts_[choice.part].anchors.X_PO[choice.pair]);
    for (size_t j = 0; j < count; ++j) {
      if (choices[j].part != choice.part) continue;
      batch.pose_distance[i * count + j] =
          std::sqrt((twins.colwise() - codes.col(j)).colwise().squaredNorm().minCoeff());
    }
  }
}

TrainingBatch TrainingData::Batch(int iteration) const {
  const std::vector<Choice> choices = Choose(iteration);
  TrainingBatch batch;
  batch.count = options_.batch;
  for (const Choice& choice : choices) {
    const auto anchor = parts_[choice.part].anchors.patch(choice.pair);
    const auto code = parts_[choice.part].codes.patch(choice.pair);
    batch.anchors.insert(batch.anchors.end(), anchor.begin(), anchor.end());
    batch.codes.insert(batch.codes.end(), code.begin(), code.end());
  }
  FillDistances(choices, batch);
  return batch;
}

}  // namespace pickbed
