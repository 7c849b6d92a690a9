// Convolutional autoencoder of local patches. Kehl et al., Deep Learning of Local RGB-D Patches for
// 3D Object Detection and 6D Pose Estimation, ECCV 2016, section 3.1. The network reconstructs its
// input through a narrow layer, whose values are the descriptor. The loss is the mean squared
// difference of patch and reconstruction. Here the encoder is the trunk of the other networks. The
// decoder is a full layer and two transposed convolutions. The descriptor has unit norm, so that
// all distances have the same scale.

#include "perception/networks/kehl.h"

#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>
#include <torch/types.h>

#include "perception/networks/fixed_layers.h"
#include "perception/networks/patch_network.h"
#include "perception/networks/training_tensors.h"
#include "perception/networks/trunk.h"

namespace pickbed::perception {
namespace {

class Autoencoder : public PatchNetwork, public torch::nn::Module {
 public:
  Autoencoder(const AutoencoderOptions& options, int length) : options_(options) {
    using torch::nn::ConvTranspose2dOptions;
    trunk_ = register_module("trunk", std::make_shared<PatchTrunk>());
    code_ = register_module("code", torch::nn::Linear(PatchTrunk::kFeatures, length));
    unfold_ = register_module("unfold", torch::nn::Linear(length, kMaps * kArea));
    widen_ = register_module(
        "widen",
        torch::nn::ConvTranspose2d(ConvTranspose2dOptions(kMaps, kMaps, 4).stride(2).padding(1)));
    paint_ = register_module(
        "paint", torch::nn::ConvTranspose2d(
                     ConvTranspose2dOptions(kMaps, Channels(), 4).stride(2).padding(1)));
  }

  at::Tensor Forward(const at::Tensor& patches) override {
    return UnitRows(ApplyLinear(code_, trunk_->Forward(Seen(patches))));
  }

  at::Tensor Loss(const TrainingTensors& batch, const LossOptions&) override {
    const int64_t count = batch.pose_distance.size(0);
    const at::Tensor codes = batch.patches.slice(0, count);
    const at::Tensor wanted =
        options_.target == "positive" ? torch::cat({codes, codes}) : batch.patches;
    return (Decode(Forward(batch.patches)) - wanted.slice(1, 0, Channels())).square().mean();
  }

  torch::nn::Module& module() override { return *this; }

  double MultiplyAdds() const override {
    return trunk_->MultiplyAdds() + static_cast<double>(code_->weight.numel());
  }

 private:
  static constexpr int kMaps = 8;                                        // channels of the decoder
  static constexpr int kSide = kPatchPixels / 4, kArea = kSide * kSide;  // size of its first maps

  int64_t Channels() const { return options_.channels == "depth" ? 1 : kPatchChannels; }

  // The trunk always has four input channels; unused channels are 0.
  at::Tensor Seen(const at::Tensor& patches) const {
    if (Channels() == kPatchChannels) return patches;
    const at::Tensor depth = patches.slice(1, 0, Channels());
    return torch::cat({depth, torch::zeros_like(patches.slice(1, Channels()))}, 1);
  }

  at::Tensor Decode(const at::Tensor& codes) {
    at::Tensor x = torch::relu(unfold_(codes)).view({-1, kMaps, kSide, kSide});
    return paint_(torch::relu(widen_(x)));
  }

  AutoencoderOptions options_;
  std::shared_ptr<PatchTrunk> trunk_;
  torch::nn::Linear code_{nullptr}, unfold_{nullptr};
  torch::nn::ConvTranspose2d widen_{nullptr}, paint_{nullptr};
};

}  // namespace

void AutoencoderOptions::Visit(SettingsVisitor& v) {
  v.RenamedValue("target", "twin", "positive");
  v.Text("target", target, {"itself", "positive"}, "patch that the decoder reconstructs");
  v.Text("channels", channels, {"depth", "depth_normals", "rgbd"},
         "channels of the patch that the network sees");
}

std::unique_ptr<PatchNetwork> MakeAutoencoder(const NetworkOptions& options, int) {
  return std::make_unique<Autoencoder>(options.autoencoder, options.descriptor);
}

PatchChannels AutoencoderChannels(const NetworkOptions& options) {
  return options.autoencoder.channels == "rgbd" ? PatchChannels::kDepthColor
                                                : PatchChannels::kDepthNormals;
}

}  // namespace pickbed::perception
