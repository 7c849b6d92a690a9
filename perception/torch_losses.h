#pragma once

// What a descriptor network is taught: descriptors of patches that show (nearly) the same pose
// shall be near, others far. The pose distance decides, so that symmetric poses count as one.

#include <string>

#include "scenes/settings.h"

namespace at {
class Tensor;
}

namespace pickbed {

struct LossOptions {
  std::string kind = "triplet";  // triplet | infonce
  double margin = 0.01;          // m of the triplet term
  double dissimilar = 0.2;       // pose distance from which a code patch is a negative, diameters
  int negatives = 16;            // hardest ones kept per anchor
  double pair_weight = 1.0;      // of the pair term
  double sigma = 0.07;           // infonce: width of the soft targets, diameters
  double temperature = 0.1;      // infonce
  void Visit(SettingsVisitor& v);
};

// anchors, codes: count x length, rows of unit length, row i of both shows nearly the same pose.
// pose_distance: count x count, of anchor i and code j, in diameters; large for different parts.
// Result: a scalar with gradient.

// Triplet and pair terms of Wohlhart and Lepetit, CVPR 2015, eq. 2 and 3: mean of
// max(0, 1 - |f_i - f_k| / (|f_i - f_j| + m)) over the hardest dissimilar codes k of the batch,
// plus mean of |f_i - f_j|^2.
at::Tensor TripletAndPairLoss(const at::Tensor& anchors, const at::Tensor& codes,
                              const at::Tensor& pose_distance, const LossOptions& options);

// InfoNCE (van den Oord et al. 2018) with soft targets exp(-d^2 / (2 sigma^2)).
at::Tensor SoftInfoNceLoss(const at::Tensor& anchors, const at::Tensor& codes,
                           const at::Tensor& pose_distance, const LossOptions& options);

// By options.kind.
at::Tensor DescriptorLoss(const at::Tensor& anchors, const at::Tensor& codes,
                          const at::Tensor& pose_distance, const LossOptions& options);

}  // namespace pickbed
