#include "perception/networks/wohlhart.h"

#include <torch/types.h>
#include <torch/utils.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/networks/torch_runtime.h"
#include "perception/networks/wohlhart_layers.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

constexpr int64_t kCropChunk = 64;  // crops per forward pass; more do not fit the CPU caches

// Returns distances computed from differences. A matrix product is inaccurate for small distances
// between rows of large norm. The gradient at distance zero is 0.
at::Tensor Distances(const at::Tensor& a, const at::Tensor& b) {
  constexpr int64_t kNoMatrixProduct = 2;
  return torch::cdist(a, b, 2.0, kNoMatrixProduct);
}

}  // namespace

int WohlhartChannels(const WohlhartOptions& options) {
  return options.input == "depth" ? 1 : options.input == "rgb" ? 3 : 4;
}

at::Tensor WohlhartTensor(const CropSet& crops, int64_t begin, int64_t count,
                          const WohlhartOptions& options, const torch::Device& device) {
  const int channels = WohlhartChannels(options);
  const bool has_depth = channels != 3;
  std::vector<float> values(count * kCropArea * channels);
  float* next = values.data();
  for (int64_t pixel = begin * kCropArea; pixel < (begin + count) * kCropArea; ++pixel) {
    const double depth = crops.depth[pixel] / (options.depth_reach * kCropDepthUnit);
    if (has_depth) *next++ = static_cast<float>(std::clamp(depth, -1.0, 1.0));
    if (channels == 1) continue;
    const bool is_seen = !has_depth || std::abs(depth) < 1;
    for (const uint8_t value : {crops.color[pixel].r, crops.color[pixel].g, crops.color[pixel].b}) {
      *next++ = is_seen ? static_cast<float>(value) / 255.0f - 0.5f : 0;
    }
  }
  // Pixel by pixel is what oneDNN's convolutions of few channels are fastest with.
  return torch::from_blob(values.data(), {count, kCropPixels, kCropPixels, channels}, torch::kFloat)
      .clone()
      .permute({0, 3, 1, 2})
      .to(device);
}

void WohlhartOptions::Visit(SettingsVisitor& v) {
  v.Text("input", input, {"depth", "rgb", "rgbd"}, "channels of the crop that the network sees");
  v.Integer("descriptor", descriptor, {2, 1024}, "length of the descriptor");
  v.Real("depth_reach", depth_reach, {0.1, 1},
         "half of the depth range about the crop center, over the crop's side");
  v.Real("margin", margin, {1e-6, 10}, "margin m of the triplet term");
  v.Bool("dynamic_margin", dynamic_margin,
         "whether the margin is the angle between the poses (Zakharov 2017)");
  v.Real("class_margin", class_margin, {std::numbers::pi, 100},
         "dynamic margin for templates of another object");
  v.RenamedKey("least_turn_rad", "min_rotation_rad");
  v.Real("min_rotation_rad", min_rotation_rad, {0, std::numbers::pi},
         "minimum angle by which a pusher exceeds the puller, rad");
  v.Integer("pushers", pushers, {1, 10000}, "number of hardest templates in the batch per anchor");
  v.Real("pair_weight", pair_weight, {0, 100}, "weight of the pair term");
  v.Real("weight_decay", weight_decay, {0, 1}, "weight decay, lambda of |w|^2");
  v.Integer("anchors", anchors, {2, 10000},
            "number of anchor crops per batch, with three templates each");
  v.Integer("iterations", iterations, {1, 1000000}, "number of training steps per object");
  v.Integer("mine_every", mine_every, {1, 1000000}, "number of steps between two rounds of mining");
  v.Real("learning_rate", learning_rate, {1e-7, 1},
         "learning rate of Adam at the start of the cosine schedule");
  v.Group(
      "augment", [&](SettingsVisitor& g) { augment.Visit(g); }, "augmentation of the crops");
}

at::Tensor WohlhartLoss(const at::Tensor& anchors, const at::Tensor& templates,
                        const at::Tensor& puller, const at::Tensor& pose_distance,
                        const WohlhartOptions& options) {
  const at::Tensor plain = Distances(anchors, templates);
  // Distances are squared in Zakharov 2017, eq. 2, but not in the released code of 2015.
  const at::Tensor distance = options.dynamic_margin ? plain.square() : plain;
  const at::Tensor column = puller.unsqueeze(1);
  const at::Tensor near = distance.gather(1, column);
  const at::Tensor is_other = pose_distance >= kOtherObject;
  const at::Tensor margin = options.dynamic_margin
                                ? pose_distance.masked_fill(is_other, options.class_margin)
                                : torch::full_like(pose_distance, options.margin);
  const at::Tensor no_pusher =
      pose_distance <= pose_distance.gather(1, column) + options.min_rotation_rad;
  // Eq. 2: max(0, 1 - |f_i - f_k| / (|f_i - f_j| + m)).
  const at::Tensor hinge = torch::relu(1 - distance / (near + margin)).masked_fill(no_pusher, 0.0);
  const int64_t kept = std::min<int64_t>(options.pushers, hinge.size(1));
  // Eq. 3: |f_i - f_j|.
  return std::get<0>(hinge.topk(kept, 1)).mean() + options.pair_weight * near.mean();
}

WohlhartNetwork::WohlhartNetwork(const WohlhartOptions& options, uint64_t seed) {
  CheckSettings("WohlhartOptions", options);
  impl_ = std::make_unique<Impl>(options, seed);
}
WohlhartNetwork::~WohlhartNetwork() = default;
WohlhartNetwork::WohlhartNetwork(WohlhartNetwork&&) noexcept = default;

int WohlhartNetwork::length() const { return impl_->options.descriptor; }

int64_t WohlhartNetwork::weights() const { return static_cast<int64_t>(Weights().size()); }

std::vector<float> WohlhartNetwork::Weights() const { return WeightsOf(*impl_->layers); }

void WohlhartNetwork::SetWeights(std::span<const float> weights) {
  SetWeightsOf(*impl_->layers, weights);
}

std::vector<float> WohlhartNetwork::Describe(const CropSet& crops, int threads) const {
  const int64_t count = static_cast<int64_t>(crops.size());
  std::vector<float> rows(count * length());
  const int chunks = static_cast<int>((count + kCropChunk - 1) / kCropChunk);
  ForRanges(chunks, threads, [&](int begin, int end) {
    const torch::InferenceMode no_gradients;  // applies to the current thread only
    for (int64_t first = begin * kCropChunk; first < std::min(count, end * kCropChunk);
         first += kCropChunk) {
      const int64_t size = std::min(kCropChunk, count - first);
      const at::Tensor values =
          impl_->layers->Forward(WohlhartTensor(crops, first, size, impl_->options, impl_->device))
              .cpu()
              .contiguous();
      std::copy_n(values.data_ptr<float>(), values.numel(), rows.begin() + first * length());
    }
  });
  return rows;
}

}  // namespace pickbed::perception
