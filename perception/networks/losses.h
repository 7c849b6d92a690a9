#pragma once

// Losses of descriptor networks: descriptors of patches with nearly the same pose shall be near,
// others far. The pose distance defines what is near, so symmetric poses count as equal.

#include <string>

#include "perception/layer.h"
#include "scenes/base/settings.h"

namespace at {
class Tensor;
}

namespace pickbed::perception {

struct LossOptions {
  std::string kind = "triplet";  // triplet | infonce
  double margin = 0.01;          // m of the triplet term
  double dissimilar = 0.2;       // minimum pose distance of a negative code patch, diameters
  int negatives = 16;            // hardest negatives kept per anchor
  double pair_weight = 1.0;      // weight of the pair term
  double sigma = 0.07;           // infonce: width of the soft targets, diameters
  double temperature = 0.1;      // infonce
  void Visit(SettingsVisitor& v);
};

// Inputs of the losses below:
// - anchors, codes: count x length, rows of unit norm; row i of both shows nearly the same pose
// - pose_distance: count x count, anchor i to code j, in diameters; large for different objects
// They return a scalar with gradient.

// Triplet and pair terms. Returns the mean of max(0, 1 - |f_i - f_k| / (|f_i - f_j| + m)) over the
// hardest dissimilar codes k of the batch, plus the weighted mean of |f_i - f_j|^2. Wohlhart and
// Lepetit, CVPR 2015, eq. 2 and 3.
at::Tensor TripletAndPairLoss(const at::Tensor& anchors, const at::Tensor& codes,
                              const at::Tensor& pose_distance, const LossOptions& options);

// InfoNCE (van den Oord et al. 2018) with soft targets exp(-d^2 / (2 sigma^2)).
at::Tensor SoftInfoNceLoss(const at::Tensor& anchors, const at::Tensor& codes,
                           const at::Tensor& pose_distance, const LossOptions& options);

// The loss selected by options.kind.
at::Tensor DescriptorLoss(const at::Tensor& anchors, const at::Tensor& codes,
                          const at::Tensor& pose_distance, const LossOptions& options);

}  // namespace pickbed::perception
