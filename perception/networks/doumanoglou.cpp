// Direct regression of the object pose from a local patch, with a siamese term. Doumanoglou et al.,
// Siamese Regression Networks with Efficient Mid-level Feature Extraction for 3D Object Pose
// Estimation, 2016: L = L_regress(q) + lambda | |f_i - f_j| - d(pose_i, pose_j) |. The formula is
// taken from secondary sources. q is the unit quaternion of the object in the patch frame. The
// network also regresses the offset from the patch to the object's center of mass, because a patch
// is not centered on the object. Both terms treat q and -q, and all symmetric poses, as one pose.
// The regression term uses the nearest of them, and d is the distance of PoseEmbedding.
//
// The features f are not normalised, because their distances shall equal pose distances. All
// objects share trunk and features. Each object has its own rows of the last layer, and a softmax
// classifies the object.

#include "perception/networks/doumanoglou.h"

#include <torch/nn/functional/loss.h>
#include <torch/nn/modules/linear.h>
#include <torch/types.h>

#include <cmath>

#include "perception/features/pose_targets.h"
#include "perception/networks/fixed_layers.h"
#include "perception/networks/patch_network.h"
#include "perception/networks/training_tensors.h"
#include "perception/networks/trunk.h"

namespace pickbed::perception {
namespace {

// Lower bound before a square root, because its slope is infinite at zero.
constexpr double kRootFloor = 1e-12;

at::Tensor Root(const at::Tensor& squared) { return squared.clamp_min(kRootFloor).sqrt(); }

// Sum over the last dimension, one value after the other as on every CPU.
at::Tensor SumOfLast(const at::Tensor& rows) {
  const std::vector<at::Tensor> columns = rows.unbind(-1);
  at::Tensor sum = columns[0];
  for (size_t i = 1; i < columns.size(); ++i) sum = sum + columns[i];
  return sum.unsqueeze(-1);
}

at::Tensor Unit(const at::Tensor& rows) { return rows / Root(SumOfLast(rows.square())); }

at::Tensor CrossProduct(const at::Tensor& a, const at::Tensor& b) {
  const std::vector<at::Tensor> u = a.unbind(-1), v = b.unbind(-1);
  return torch::stack(
      {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]}, -1);
}

class SiameseRegression : public PatchNetwork, public torch::nn::Module {
 public:
  SiameseRegression(const NetworkOptions& options, int object_count)
      : options_(options.regression), object_count_(object_count) {
    trunk_ = register_module("trunk", std::make_shared<PatchTrunk>());
    features_ =
        register_module("features", torch::nn::Linear(PatchTrunk::kFeatures, options.descriptor));
    hidden_ = register_module("hidden", torch::nn::Linear(options.descriptor, kHidden));
    last_ =
        register_module("last", torch::nn::Linear(kHidden, object_count * (Rotation() + 3 + 1)));
  }

  at::Tensor Forward(const at::Tensor& patches) override {
    return ApplyLinear(features_, trunk_->Forward(patches));
  }

  at::Tensor Poses(const at::Tensor& patches) override {
    const at::Tensor out = Regress(Forward(patches));
    const at::Tensor shares = ClassProbabilities(out.select(2, 0)).unsqueeze(2);
    const at::Tensor R_PO = RotationMatrices(out.slice(2, 4).flatten(0, 1));
    return torch::cat({shares, R_PO.view({-1, object_count_, 9}), out.slice(2, 1, 4)}, 2);
  }

  at::Tensor Loss(const TrainingTensors& batch, const LossOptions&) override {
    const at::Tensor rows = Forward(batch.patches);
    const at::Tensor out = Regress(rows);
    const at::Tensor of_object =
        out.gather(1, batch.objects.view({-1, 1, 1}).expand({-1, 1, out.size(2)})).squeeze(1);
    const at::Tensor off = Root((of_object.slice(1, 1, 4) - batch.centers).square().sum(1));
    at::Tensor loss = QuaternionDistance(of_object.slice(1, 4), batch.rotations).mean() +
                      options_.offset_weight * off.mean();
    if (object_count_ > 1) {
      loss = loss + options_.object_weight *
                        torch::nn::functional::cross_entropy(out.select(2, 0), batch.objects);
    }
    if (options_.siamese_weight == 0) return loss;
    const int64_t count = batch.pose_distance.size(0);
    const at::Tensor same =
        batch.objects.slice(0, 0, count).unsqueeze(1) == batch.objects.slice(0, count).unsqueeze(0);
    return loss + options_.siamese_weight * SiameseLoss(rows.slice(0, 0, count),
                                                        rows.slice(0, count), batch.pose_distance,
                                                        same);
  }

  torch::nn::Module& module() override { return *this; }

  double MultiplyAdds() const override {
    return trunk_->MultiplyAdds() +
           static_cast<double>(features_->weight.numel() + hidden_->weight.numel() +
                               last_->weight.numel());
  }

 private:
  static constexpr int kHidden = 128;

  int64_t Rotation() const { return options_.rotation == "six_d" ? 6 : 4; }

  // Returns N x object_count x (logit of the object, offset, rotation).
  at::Tensor Regress(const at::Tensor& features) {
    const at::Tensor out =
        ApplyLinear(last_, torch::relu(ApplyLinear(hidden_, torch::relu(features))));
    return out.view({-1, object_count_, Rotation() + 3 + 1});
  }

  RegressionOptions options_;
  int64_t object_count_;
  std::shared_ptr<PatchTrunk> trunk_;
  torch::nn::Linear features_{nullptr}, hidden_{nullptr}, last_{nullptr};
};

}  // namespace

void RegressionOptions::Visit(SettingsVisitor& v) {
  v.Text("rotation", rotation, {"quaternion", "six_d"}, "form of the regressed rotation");
  v.Real("siamese_weight", siamese_weight, {0, 1000},
         "weight of the siamese term; 0 = plain regression");
  v.Real("offset_weight", offset_weight, {0, 1000}, "weight of the offset to the object center");
  v.RenamedKey("part_weight", "object_weight");
  v.Real("object_weight", object_weight, {0, 1000}, "weight of the classification of objects");
}

at::Tensor RotationMatrices(const at::Tensor& values) {
  if (values.size(-1) == 6) {
    const at::Tensor x = Unit(values.slice(-1, 0, 3)), y0 = values.slice(-1, 3);
    const at::Tensor y = Unit(y0 - SumOfLast(x * y0) * x);
    return torch::stack({x, y, CrossProduct(x, y)}, -1);
  }
  const std::vector<at::Tensor> q = Unit(values).unbind(-1);
  const auto entry = [&](int a, int b, int c, int d, double sign) {
    return 2 * (q[a] * q[b] + sign * q[c] * q[d]);
  };
  const auto diagonal = [&](int a, int b) { return 1 - 2 * (q[a].square() + q[b].square()); };
  const at::Tensor rows =
      torch::stack({diagonal(2, 3), entry(1, 2, 0, 3, -1), entry(1, 3, 0, 2, 1),
                    entry(1, 2, 0, 3, 1), diagonal(1, 3), entry(2, 3, 0, 1, -1),
                    entry(1, 3, 0, 2, -1), entry(2, 3, 0, 1, 1), diagonal(1, 2)},
                   -1);
  std::vector<int64_t> shape = values.sizes().vec();
  shape.back() = 3;
  shape.push_back(3);
  return rows.view(shape);
}

at::Tensor QuaternionDistance(const at::Tensor& values, const at::Tensor& rotations) {
  if (values.size(1) == 4) {
    const at::Tensor cosine = (Unit(values).unsqueeze(1) * rotations).sum(2).abs();
    return Root(2 - 2 * std::get<0>(cosine.max(1)));
  }
  const at::Tensor off = RotationMatrices(values).unsqueeze(1) - RotationMatrices(rotations);
  return Root(std::get<0>(off.square().sum({2, 3}).min(1)) / 8);
}

at::Tensor SiameseLoss(const at::Tensor& anchors, const at::Tensor& codes,
                       const at::Tensor& pose_distance, const at::Tensor& same_object) {
  const at::Tensor squared = anchors.square().sum(1).unsqueeze(1) +
                             codes.square().sum(1).unsqueeze(0) - 2 * anchors.mm(codes.t());
  const at::Tensor pairs = same_object.to(anchors.scalar_type());
  const at::Tensor off = (Root(squared) - pose_distance).abs();
  return (pairs * off).sum() / pairs.sum().clamp_min(1);
}

std::unique_ptr<PatchNetwork> MakeSiameseRegression(const NetworkOptions& options,
                                                    int object_count) {
  return std::make_unique<SiameseRegression>(options, object_count);
}

}  // namespace pickbed::perception
