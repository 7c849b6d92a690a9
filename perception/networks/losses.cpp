#include "perception/networks/losses.h"

#include <torch/types.h>

#include <algorithm>

namespace pickbed::perception {
namespace {

// Lower bound of squared distances, because the slope of the square root is infinite at zero.
constexpr double kMinSquared = 1e-6;

at::Tensor SquaredDistances(const at::Tensor& similarity) {
  return (2.0 - 2.0 * similarity).clamp_min(kMinSquared);
}

}  // namespace

void LossOptions::Visit(SettingsVisitor& v) {
  v.Text("kind", kind, {"triplet", "infonce"},
         "form of the loss: triplet and pair terms, or soft InfoNCE");
  v.Real("margin", margin, {1e-6, 1}, "margin m of the triplet term");
  v.Real("dissimilar", dissimilar, {0, 10}, "minimum pose distance of a negative, diameters");
  v.Integer("negatives", negatives, {1, 10000},
            "number of hardest negatives in the batch per anchor");
  v.Real("pair_weight", pair_weight, {0, 100}, "weight of the pair term");
  v.Real("sigma", sigma, {1e-3, 1}, "width of InfoNCE's soft targets, diameters");
  v.Real("temperature", temperature, {1e-3, 10}, "temperature of InfoNCE");
}

at::Tensor TripletAndPairLoss(const at::Tensor& anchors, const at::Tensor& codes,
                              const at::Tensor& pose_distance, const LossOptions& options) {
  const at::Tensor squared = SquaredDistances(anchors.mm(codes.t()));
  const at::Tensor positive = squared.diagonal();
  const at::Tensor ratio = squared.sqrt() / (positive.sqrt().unsqueeze(1) + options.margin);
  const at::Tensor hinge =
      torch::relu(1.0 - ratio).masked_fill(pose_distance < options.dissimilar, 0.0);
  const int64_t kept = std::min<int64_t>(options.negatives, hinge.size(1));
  const at::Tensor hardest = std::get<0>(hinge.topk(kept, 1));
  return hardest.mean() + options.pair_weight * positive.mean();
}

at::Tensor SoftInfoNceLoss(const at::Tensor& anchors, const at::Tensor& codes,
                           const at::Tensor& pose_distance, const LossOptions& options) {
  const at::Tensor logits = anchors.mm(codes.t()) / options.temperature;
  at::Tensor targets = torch::exp(-pose_distance.square() / (2 * options.sigma * options.sigma));
  // The positive pair has full weight, even if the codebook is too coarse to contain a near pose.
  targets = torch::maximum(targets, torch::eye(targets.size(0), targets.options()));
  targets = targets / targets.sum(1, true);
  return -(targets * torch::log_softmax(logits, 1)).sum(1).mean();
}

at::Tensor DescriptorLoss(const at::Tensor& anchors, const at::Tensor& codes,
                          const at::Tensor& pose_distance, const LossOptions& options) {
  return options.kind == "infonce" ? SoftInfoNceLoss(anchors, codes, pose_distance, options)
                                   : TripletAndPairLoss(anchors, codes, pose_distance, options);
}

}  // namespace pickbed::perception
