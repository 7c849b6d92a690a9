#pragma once

// The descriptor of Wohlhart and Lepetit, "Learning Descriptors for Object Recognition and 3D Pose
// Estimation", CVPR 2015: crops of the same part in nearly the same pose come to lie near each
// other, others far apart, so that the nearest template tells part and pose. With in-plane turns
// (crop_views.h) and `dynamic_margin` it is that of Zakharov et al., "3D Object Instance
// Recognition and Pose Estimation Using Triplet Loss with Dynamic Margin", IROS 2017. Network,
// loss, mining and training stand in wohlhart.cpp.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/crop_augment.h"
#include "perception/crop_lesson.h"
#include "scenes/settings.h"

namespace at {
class Tensor;
}

namespace pickbed {

struct WohlhartOptions {
  std::string input = "rgbd";  // depth | rgb | rgbd: 1, 3 or 4 channels
  int descriptor = 32;         // length
  // Half the depth that is seen about the centre, over the crop's side, 0.1..1. What stands before
  // or behind it is no piece of the part: its depth is drawn onto that end, its colour (of rgbd) is
  // left out. Of input rgb, which has no depth, all is seen.
  double depth_reach = 0.5;
  double margin = 0.01;          // m of eq. 2
  bool dynamic_margin = false;   // m by the angle between the poses, and squared distances
  double class_margin = 4;       // of templates of another part then; above pi
  double least_turn_rad = 0.05;  // by which a pusher's pose is farther than the puller's
  int pushers = 16;              // triplets of an anchor: the hardest templates of the batch
  double pair_weight = 1;        // of L_pairs
  double weight_decay = 1e-6;    // lambda of |w|^2
  int anchors = 64;             // of a batch; with a puller, a wrong pose and a wrong part for each
  int iterations = 800;         // steps a part
  int mine_every = 100;         // steps between two rounds that look up the hardest wrong templates
  double learning_rate = 1e-3;  // of Adam, falls to zero along a cosine
  CropAugmentOptions augment = {};
  void Visit(SettingsVisitor& v);
};

// Pose distance of a template of another part.
inline constexpr double kOtherPart = 100;

// L_triplets + L_pairs of anchors and the templates of a batch (eq. 1 to 3), each as a mean over
// the batch, distances not squared as in the authors' released code. anchors: count x length,
// templates: rows x length; puller: the row of each anchor's closest template; pose_distance: count
// x rows, rad, kOtherPart for another part. Result: a scalar with gradient.
at::Tensor WohlhartLoss(const at::Tensor& anchors, const at::Tensor& templates,
                        const at::Tensor& puller, const at::Tensor& pose_distance,
                        const WohlhartOptions& options);

class WohlhartNetwork {
 public:
  // Fresh weights drawn from `seed`.
  WohlhartNetwork(const WohlhartOptions& options, uint64_t seed);
  ~WohlhartNetwork();
  WohlhartNetwork(WohlhartNetwork&&) noexcept;

  int length() const;
  int64_t weights() const;  // how many
  std::vector<float> Weights() const;
  // Throws InputError when the number does not fit this network.
  void SetWeights(std::span<const float> weights);
  // A row of `length` values for each crop. The same for any number of threads.
  std::vector<float> Describe(const CropSet& crops, int threads = 1) const;

 private:
  friend class WohlhartTrainer;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct WohlhartJob {
  const CropLesson& lesson;
  uint64_t seed = 0;
  // Written after each round and at the end; read where it exists and belongs to the same settings,
  // parts and views. Empty = none.
  std::filesystem::path checkpoint;
  std::function<bool(double share, double loss)> on_progress;  // false = stop; may be empty
  int threads = 1;
};

// Null when stopped. The same seed gives the same weights, also after stops and for any number of
// threads. Throws InputError for a lesson without views and for a checkpoint of another training.
std::unique_ptr<WohlhartNetwork> TrainWohlhart(const WohlhartJob& job,
                                               const WohlhartOptions& options);

}  // namespace pickbed
