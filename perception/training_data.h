#pragma once

// The pairs of patches that a descriptor network learns from, held in memory, and the batches drawn
// from them.

#include <functional>
#include <vector>

#include "perception/pose_embedding.h"
#include "perception/training.h"
#include "perception/twin_patches.h"

namespace pickbed {

// What the piles tell of the camera, for code books of views that look alike.
struct PileCamera {
  double focal_px = 0;
  double distance_m = 0;         // camera to parts, middle
  double distance_spread = 0.1;  // relative half range that holds nearly all parts
};

class TrainingData {
 public:
  // No pairs yet; sides_m: patch side by object.
  TrainingData(const ObjectSet& objects, std::vector<double> sides_m,
               const TrainingOptions& options);

  // on_share(0..1) returns false to stop, then so does Collect. Throws InputError when a part was
  // never seen well enough.
  bool Collect(LabelledViewSource& views, const std::function<bool(double share)>& on_share);

  // Depends on seed and iteration alone.
  TrainingBatch Batch(int iteration) const;

  const PileCamera& camera() const { return camera_; }
  size_t size() const;  // pairs

 private:
  struct Choice {
    int part = 0;
    int pair = 0;
  };
  std::vector<Choice> Choose(int iteration) const;
  void FillDistances(const std::vector<Choice>& choices, TrainingBatch& batch) const;
  void SetCamera(const CameraIntrinsics& intrinsics, std::vector<double> distances_m);

  const ObjectSet& objects_;
  std::vector<double> sides_m_;
  TrainingOptions options_;
  PileCamera camera_;
  std::vector<PatchPairs> parts_;
  std::vector<PoseEmbedding> embeddings_;
};

}  // namespace pickbed
