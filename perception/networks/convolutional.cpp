// Convolutional network: the trunk and a full layer to D values of unit norm, 80 k weights. It is
// trained with the descriptor losses of losses.h.

#include <torch/nn/modules/linear.h>
#include <torch/types.h>

#include "perception/networks/fixed_layers.h"
#include "perception/networks/patch_network.h"
#include "perception/networks/training_tensors.h"
#include "perception/networks/trunk.h"

namespace pickbed::perception {
namespace {

class ConvolutionalNetwork : public PatchNetwork, public torch::nn::Module {
 public:
  explicit ConvolutionalNetwork(int length) {
    trunk_ = register_module("trunk", std::make_shared<PatchTrunk>());
    last_ = register_module("last", torch::nn::Linear(PatchTrunk::kFeatures, length));
  }

  at::Tensor Forward(const at::Tensor& patches) override {
    return UnitRows(ApplyLinear(last_, trunk_->Forward(patches)));
  }

  at::Tensor Loss(const TrainingTensors& batch, const LossOptions& options) override {
    const at::Tensor rows = Forward(batch.patches);
    const int64_t count = batch.pose_distance.size(0);
    return DescriptorLoss(rows.slice(0, 0, count), rows.slice(0, count), batch.pose_distance,
                          options);
  }

  torch::nn::Module& module() override { return *this; }

  double MultiplyAdds() const override {
    return trunk_->MultiplyAdds() + static_cast<double>(last_->weight.numel());
  }

 private:
  std::shared_ptr<PatchTrunk> trunk_;
  torch::nn::Linear last_{nullptr};
};

}  // namespace

std::unique_ptr<PatchNetwork> MakeConvolutionalNetwork(const NetworkOptions& options, int) {
  return std::make_unique<ConvolutionalNetwork>(options.descriptor);
}

}  // namespace pickbed::perception
