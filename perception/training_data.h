#pragma once

// The patches that a descriptor network learns from, held in memory, and the batches drawn from
// them.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "perception/labelled_patches.h"
#include "perception/pose_embedding.h"
#include "perception/training.h"

namespace pickbed {

// How far the collection is, 0..1; false = stop.
using OnShare = std::function<bool(double share)>;

// What the piles tell of the camera, for isolated views that look alike.
struct PileCamera {
  double focal_px = 0;
  double distance_m = 0;         // mean camera-to-part distance
  double distance_spread = 0.1;  // relative half range that holds nearly all parts
};

class TrainingData {
 public:
  // Empty sets of patches; sides_m: patch side by object.
  TrainingData(const ObjectSet& objects, std::vector<double> sides_m,
               const TrainingOptions& options);

  // Each false when stopped by on_share. Isolated views come second: they copy the piles' camera.
  bool CollectPiles(LabelledViewSource& views, const OnShare& on_share);
  bool CollectIsolated(LabelledViewSource& views, const OnShare& on_share);
  // Finds the pose-nearest code patches of every anchor. Throws InputError when a part was never
  // seen well enough.
  void FindPositives();

  // Depends on seed and iteration alone.
  TrainingBatch Batch(int iteration) const;

  const PileCamera& camera() const { return camera_; }
  const LabelledPatches& codes(int object) const { return parts_[object].codes; }

 private:
  struct Part {
    LabelledPatches anchors;  // from piles
    LabelledPatches codes;    // from isolated views
    Eigen::Matrix<float, 24, Eigen::Dynamic> code_points;
    std::vector<int> positives;  // anchors x options.positives, indices of codes
  };
  struct Pair {
    int part = 0;
    int anchor = 0;
    int code = 0;
  };
  std::vector<Pair> DrawPairs(int iteration) const;
  void FillDistances(const std::vector<Pair>& pairs, TrainingBatch& batch) const;

  const ObjectSet& objects_;
  std::vector<double> sides_m_;
  TrainingOptions options_;
  PileCamera camera_;
  std::vector<Part> parts_;
  std::vector<PoseEmbedding> embeddings_;
};

}  // namespace pickbed
