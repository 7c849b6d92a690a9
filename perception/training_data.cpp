#include "perception/training_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "perception/neighbors.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

// Pose distance of two different parts: beyond every threshold.
constexpr float kOtherPart = 10.0f;

// Pose space has six dimensions: few leaves hold nearly all true neighbours.
constexpr NeighborOptions kPoseIndex{.trees = 4, .checks = 128};

}  // namespace

TrainingData::TrainingData(const ObjectSet& objects, std::vector<double> sides_m,
                           const TrainingOptions& options)
    : objects_(objects), sides_m_(std::move(sides_m)), options_(options), parts_(objects.size()) {
  for (const auto& object : objects) embeddings_.emplace_back(*object);
}

bool TrainingData::CollectPiles(LabelledViewSource& views, const OnShare& on_share) {
  const int piles = options_.piles * static_cast<int>(objects_.size());
  std::vector<LabelledPatches> anchors(objects_.size());
  std::vector<double> distances;
  for (int i = 0; i < piles; ++i) {
    Rng rng = Rng::Derive(options_.seed, i, "training/pile");
    for (const LabelledView& view : views.Pile(rng.Next(), options_.views_per_pile)) {
      AppendPilePatches(view, sides_m_, options_.min_visible, options_.patches_per_view, rng,
                        anchors);
      camera_.focal_px = view.frame.intrinsics.fx;
      for (const LabelledInstance& instance : view.instances) {
        distances.push_back(instance.X_CO.translation().norm());
      }
    }
    if (!on_share(static_cast<double>(i + 1) / piles)) return false;
  }
  CheckInput(!distances.empty(), "the training piles show no part");
  // The middle 90 % of the distances.
  std::sort(distances.begin(), distances.end());
  const double low = distances[distances.size() / 20];
  const double high = distances[distances.size() - 1 - distances.size() / 20];
  camera_.distance_m = 0.5 * (low + high);
  camera_.distance_spread = std::clamp((high - low) / (high + low), 0.02, 0.5);
  for (size_t p = 0; p < parts_.size(); ++p) parts_[p].anchors = std::move(anchors[p]);
  return true;
}

bool TrainingData::CollectIsolated(LabelledViewSource& views, const OnShare& on_share) {
  IsolatedOptions isolated;
  isolated.views = options_.code_views;
  isolated.patches_per_view = options_.code_patches;
  isolated.focal_px = camera_.focal_px;
  isolated.distance_m = camera_.distance_m;
  isolated.distance_spread = camera_.distance_spread;
  for (size_t p = 0; p < parts_.size(); ++p) {
    LabelledPatches& codes = parts_[p].codes;
    bool go_on = true;
    ForEachIsolatedBlock(
        views, static_cast<int>(p), sides_m_[p], isolated, options_.seed,
        [&](const LabelledPatches& patches, double share) {
          codes.values.insert(codes.values.end(), patches.values.begin(), patches.values.end());
          codes.X_PO.insert(codes.X_PO.end(), patches.X_PO.begin(), patches.X_PO.end());
          return go_on = on_share((static_cast<double>(p) + share) /
                                  static_cast<double>(parts_.size()));
        });
    if (!go_on) return false;
  }
  return true;
}

void TrainingData::FindPositives() {
  for (size_t p = 0; p < parts_.size(); ++p) {
    Part& part = parts_[p];
    CheckInput(part.anchors.size() > 0 && part.codes.size() >= size_t(options_.positives),
               fmt::format("part '{}' was never seen well enough in {} training piles; raise "
                           "training.piles or lower training.min_visible",
                           objects_[p]->name, options_.piles));
    const PoseEmbedding& embedding = embeddings_[p];
    const Eigen::Index twins = embedding.twins();
    const auto count = static_cast<Eigen::Index>(part.codes.size());
    // Every code stands in the index under each of its twins, so that one query finds the nearest.
    Eigen::Matrix<float, 24, Eigen::Dynamic> points(24, count * twins);
    part.code_points.resize(24, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      points.middleCols(i * twins, twins) = embedding.EmbedTwins(part.codes.X_PO[i]);
      part.code_points.col(i) = points.col(i * twins);
    }
    const NeighborIndex index({points.data(), points.data() + points.size()}, 24, kPoseIndex);
    for (const Pose& X_PO : part.anchors.X_PO) {
      const PoseEmbedding::Point query = embedding.Embed(X_PO);
      const Neighbors found = index.Search({query.data(), 24}, options_.positives);
      for (const int row : found.rows) part.positives.push_back(row / static_cast<int>(twins));
    }
  }
}

std::vector<TrainingData::Pair> TrainingData::DrawPairs(int iteration) const {
  Rng rng = Rng::Derive(options_.seed, iteration, "training/batch");
  const int part_count = static_cast<int>(parts_.size());
  std::vector<Pair> pairs(options_.batch);
  for (int i = 0; i < options_.batch; ++i) {
    Pair& pair = pairs[i];
    const bool of_main = i < options_.main_share * options_.batch;
    pair.part = of_main ? iteration % part_count : rng.Index(part_count);
    const Part& part = parts_[pair.part];
    pair.anchor = rng.Index(static_cast<int>(part.anchors.size()));
    pair.code = part.positives[pair.anchor * options_.positives + rng.Index(options_.positives)];
  }
  return pairs;
}

void TrainingData::FillDistances(const std::vector<Pair>& pairs, TrainingBatch& batch) const {
  batch.pose_distance.assign(pairs.size() * pairs.size(), kOtherPart);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Part& part = parts_[pairs[i].part];
    const auto twins = embeddings_[pairs[i].part].EmbedTwins(part.anchors.X_PO[pairs[i].anchor]);
    for (size_t j = 0; j < pairs.size(); ++j) {
      if (pairs[j].part != pairs[i].part) continue;
      const auto code = part.code_points.col(pairs[j].code);
      batch.pose_distance[i * pairs.size() + j] =
          std::sqrt((twins.colwise() - code).colwise().squaredNorm().minCoeff());
    }
  }
}

TrainingBatch TrainingData::Batch(int iteration) const {
  const std::vector<Pair> pairs = DrawPairs(iteration);
  TrainingBatch batch;
  batch.count = options_.batch;
  for (const Pair& pair : pairs) {
    const auto anchor = parts_[pair.part].anchors.patch(pair.anchor);
    const auto code = parts_[pair.part].codes.patch(pair.code);
    batch.anchors.insert(batch.anchors.end(), anchor.begin(), anchor.end());
    batch.codes.insert(batch.codes.end(), code.begin(), code.end());
  }
  FillDistances(pairs, batch);
  return batch;
}

}  // namespace pickbed
