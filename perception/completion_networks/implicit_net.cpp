#include <torch/nn/modules/linear.h>

#include "perception/completion_networks/completion_net.h"
#include "perception/completion_networks/image_unet.h"
#include "perception/completion_networks/implicit_decoder.h"
#include "perception/completion_networks/volume_blocks.h"
#include "perception/networks/fixed_layers.h"

namespace pickbed::perception {
namespace {

constexpr int64_t kHalf = kInputCells / 2;
constexpr int64_t kFirstChannels = 8 * kInputChannels;

DenseLayer Plain(const torch::nn::Linear& layer) {
  return {layer->weight.data_ptr<float>(), layer->bias.data_ptr<float>(), layer->weight.size(1),
          layer->weight.size(0)};
}

// `code` is 1 x features x depth x height x width.
FeatureGrid Plain(const at::Tensor& code) {
  return {code.data_ptr<float>(), code.size(2), code.size(3), code.size(4), code.size(1)};
}

struct ImplicitNet : CompletionNet {
  explicit ImplicitNet(const CompletionNetworkOptions& o) {
    const auto add = [&](const char* name, int64_t in, int64_t out, int64_t kernel,
                         int64_t stride) {
      return register_module(name, std::make_shared<VolumeBlock>(in, out, kernel, stride));
    };
    first = add("first", kFirstChannels, o.width_16, 1, 1);
    second = add("second", o.width_16, o.width_16, 3, 1);
    down_8 = add("down_8", o.width_16, o.width_8, 3, 2);
    at_8 = add("at_8", o.width_8, o.width_8, 3, 1);
    down_4 = add("down_4", o.width_8, o.width_4, 3, 2);
    at_4 = add("at_4", o.width_4, o.width_4, 3, 1);
    const int64_t flat = 64 * static_cast<int64_t>(o.width_4);
    squeeze = register_module("squeeze", torch::nn::Linear(flat, o.bottleneck));
    expand = register_module("expand", torch::nn::Linear(o.bottleneck, flat));
    up_8 = add("up_8", o.width_4 + o.width_8, o.width_8, 3, 1);
    up_16 = add("up_16", o.width_8 + o.width_16, o.width_16, 3, 1);
    pixels = register_module("pixels", std::make_shared<ImageUnet>(kImageChannels, o.image_width));
    const int64_t known = o.width_16 + o.image_width + kQueryValues;
    hidden_1 = register_module("hidden_1", torch::nn::Linear(known, o.hidden));
    hidden_2 = register_module("hidden_2", torch::nn::Linear(o.hidden, o.hidden));
    last = register_module("last", torch::nn::Linear(o.hidden, 1));
  }

  // The code has width_16 features in 16^3 cells, and image_width features in 64^2 pixels.
  CompletionCode Encode(const CompletionViews& views) override {
    const int64_t n = views.channels.size(0);
    const at::Tensor x = views.channels.view({n, kInputChannels, kHalf, 2, kHalf, 2, kHalf, 2})
                             .permute({0, 1, 3, 5, 7, 2, 4, 6})
                             .reshape({n, kFirstChannels, kHalf, kHalf, kHalf});
    const at::Tensor x_16 = second->forward(first->forward(x));
    const at::Tensor x_8 = at_8->forward(down_8->forward(x_16));
    at::Tensor x_4 = at_4->forward(down_4->forward(x_8));
    x_4 = x_4 +
          ApplyLinear(expand, torch::relu(ApplyLinear(squeeze, x_4.flatten(1)))).view(x_4.sizes());
    const at::Tensor y_8 = up_8->forward(torch::cat({DoubledSize(x_4), x_8}, 1));
    return {up_16->forward(torch::cat({DoubledSize(y_8), x_16}, 1)),
            pixels->forward(views.images).unsqueeze(2)};
  }

  at::Tensor Decode(const CompletionCode& code, const at::Tensor& queries) override {
    if (!ComputedByLibtorch(hidden_1->weight, queries)) return DecodePlain(code, queries);
    const at::Tensor in_image = queries.slice(2, kImagePlace, kImagePlace + 2);
    const at::Tensor on_plane =
        torch::cat({in_image, torch::zeros_like(in_image.slice(2, 0, 1))}, 2);
    at::Tensor x = torch::cat({SampledCode(code.volume, queries.slice(2, 0, 3)),
                               SampledCode(code.image, on_plane), queries},
                              2);
    x = torch::relu(hidden_1(x));
    x = torch::relu(hidden_2(x));
    return last(x).squeeze(2);
  }

  at::Tensor DecodePlain(const CompletionCode& code, const at::Tensor& queries) const {
    const at::Tensor values = queries.contiguous();
    const int64_t points = values.size(1);
    at::Tensor logits = torch::empty({values.size(0), points});
    for (int64_t n = 0; n < values.size(0); ++n) {
      const CompletionCode own = code.Rows(n, n + 1);
      // All features of a place are read at once.
      const at::Tensor volume = own.volume.contiguous(at::MemoryFormat::ChannelsLast3d);
      const at::Tensor image = own.image.contiguous(at::MemoryFormat::ChannelsLast3d);
      const ImplicitDecoder decoder(Plain(volume), Plain(image),
                                    {Plain(hidden_1), Plain(hidden_2), Plain(last)});
      decoder.Decode(values.data_ptr<float>() + n * points * kQueryValues, points,
                     logits.data_ptr<float>() + n * points);
    }
    return logits;
  }

  // Mean cross-entropy of all queries.
  at::Tensor Loss(const CompletionTensors& step) override {
    return torch::binary_cross_entropy_with_logits(Decode(Encode(step.views), step.queries),
                                                   step.inside);
  }

  std::shared_ptr<VolumeBlock> first, second, down_8, at_8, down_4, at_4, up_8, up_16;
  std::shared_ptr<ImageUnet> pixels;
  torch::nn::Linear squeeze{nullptr}, expand{nullptr};
  torch::nn::Linear hidden_1{nullptr}, hidden_2{nullptr}, last{nullptr};
};

}  // namespace

std::shared_ptr<CompletionNet> MakeImplicitNet(const CompletionNetworkOptions& options) {
  return std::make_shared<ImplicitNet>(options);
}

}  // namespace pickbed::perception
