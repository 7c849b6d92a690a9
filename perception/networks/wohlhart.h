#pragma once

// Descriptor network of Wohlhart and Lepetit, "Learning Descriptors for Object Recognition and 3D
// Pose Estimation", CVPR 2015. Crops of the same object in nearly the same pose have near
// descriptors, and others distant ones. The nearest template therefore gives object and pose. With
// in-plane rotations (crop_views.h) and `dynamic_margin` it is the method of Zakharov et al., "3D
// Object Instance Recognition and Pose Estimation Using Triplet Loss with Dynamic Margin", IROS
// 2017. The training is in training/wohlhart_training.h.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/crops/crop_augment.h"
#include "perception/crops/crop_views.h"
#include "scenes/base/settings.h"

namespace at {
class Tensor;
}

namespace pickbed::perception {

struct WohlhartOptions {
  std::string input = "rgbd";  // depth | rgb | rgbd: 1, 3 or 4 channels
  int descriptor = 32;         // length of the descriptor
  // Half of the depth range around the crop center, over the crop's side, 0.1..1. Readings outside
  // the range do not show the object: depth is clamped to the range, and color (input rgbd) is set
  // to 0. Input rgb has no depth and uses all pixels.
  double depth_reach = 0.5;
  double margin = 0.01;            // m of eq. 2
  bool dynamic_margin = false;     // m = angle between the poses, with squared distances
  double class_margin = 4;         // dynamic margin of templates of another object; above pi
  double min_rotation_rad = 0.05;  // minimum additional angle of a pusher over the puller's angle
  int pushers = 16;                // triplets per anchor: the hardest templates of the batch
  double pair_weight = 1;          // weight of L_pairs
  double weight_decay = 1e-6;      // lambda of |w|^2
  int anchors = 64;                // per batch, each with a puller, a wrong pose and a wrong object
  int iterations = 800;            // training steps per object
  int mine_every = 100;            // steps between two rounds of mining the hardest wrong templates
  double learning_rate = 1e-3;     // of Adam; decays to zero along a cosine
  CropAugmentOptions augment = {};
  void Visit(SettingsVisitor& v);
};

// Pose distance of a template of another object.
inline constexpr double kOtherObject = 100;

// Returns L_triplets + pair_weight * L_pairs (eq. 1 to 3) as means over the batch, a scalar with
// gradient. Distances are squared only with dynamic_margin; the released code does not square them.
// - anchors: count x length; templates: rows x length
// - puller: row of the closest template of each anchor
// - pose_distance: count x rows, rad; kOtherObject for another object
at::Tensor WohlhartLoss(const at::Tensor& anchors, const at::Tensor& templates,
                        const at::Tensor& puller, const at::Tensor& pose_distance,
                        const WohlhartOptions& options);

// Maps whole-object crops to descriptors.
class WohlhartNetwork {
 public:
  // Draws new weights from `seed`.
  WohlhartNetwork(const WohlhartOptions& options, uint64_t seed);
  ~WohlhartNetwork();
  WohlhartNetwork(WohlhartNetwork&&) noexcept;

  int length() const;
  int64_t weights() const;  // number of weights
  std::vector<float> Weights() const;
  // Throws InputError if the number of weights does not fit this network.
  void SetWeights(std::span<const float> weights);
  // Returns count x length values. They do not depend on the number of threads.
  std::vector<float> Describe(const CropSet& crops, int threads = 1) const;

 private:
  friend class WohlhartTrainer;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::perception
