#include "perception/completion/completion_network.h"

#include <torch/cuda.h>
#include <torch/nn/functional/vision.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>
#include <torch/optim/adam.h>
#include <torch/types.h>
#include <torch/utils.h>

#include <algorithm>

#include "perception/networks/torch_runtime.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr int64_t kHalf = kInputCells / 2;
constexpr int64_t kFirstChannels = 8 * kInputChannels;
// Points decoded at once.
constexpr int64_t kChunk = 8192;
// Views encoded at once.
constexpr int64_t kViews = 16;

// Convolution, batch normalization, ReLU.
struct Block : torch::nn::Module {
  Block(int64_t in, int64_t out, int64_t kernel, int64_t stride) {
    convolution =
        register_module("convolution", torch::nn::Conv3d(torch::nn::Conv3dOptions(in, out, kernel)
                                                             .stride(stride)
                                                             .padding(kernel / 2)
                                                             .bias(false)));
    norm = register_module("norm", torch::nn::BatchNorm3d(out));
  }
  at::Tensor forward(const at::Tensor& x) { return torch::relu(norm(convolution(x))); }
  torch::nn::Conv3d convolution{nullptr};
  torch::nn::BatchNorm3d norm{nullptr};
};

at::Tensor DoubledSize(const at::Tensor& x) {
  return x.repeat_interleave(2, 2).repeat_interleave(2, 3).repeat_interleave(2, 4);
}

struct Net : torch::nn::Module {
  explicit Net(const CompletionNetworkOptions& o) {
    const auto add = [&](const char* name, int64_t in, int64_t out, int64_t kernel,
                         int64_t stride) {
      return register_module(name, std::make_shared<Block>(in, out, kernel, stride));
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
    hidden_1 = register_module("hidden_1", torch::nn::Linear(o.width_16 + kQueryValues, o.hidden));
    hidden_2 = register_module("hidden_2", torch::nn::Linear(o.hidden, o.hidden));
    last = register_module("last", torch::nn::Linear(o.hidden, 1));
  }

  // `channels` is n x kInputChannels x 32^3; returns n x width_16 x 16^3.
  at::Tensor Encode(const at::Tensor& channels) {
    const int64_t n = channels.size(0);
    const at::Tensor x = channels.view({n, kInputChannels, kHalf, 2, kHalf, 2, kHalf, 2})
                             .permute({0, 1, 3, 5, 7, 2, 4, 6})
                             .reshape({n, kFirstChannels, kHalf, kHalf, kHalf});
    const at::Tensor x_16 = second->forward(first->forward(x));
    const at::Tensor x_8 = at_8->forward(down_8->forward(x_16));
    at::Tensor x_4 = at_4->forward(down_4->forward(x_8));
    x_4 = x_4 + expand(torch::relu(squeeze(x_4.flatten(1)))).view(x_4.sizes());
    const at::Tensor y_8 = up_8->forward(torch::cat({DoubledSize(x_4), x_8}, 1));
    return up_16->forward(torch::cat({DoubledSize(y_8), x_16}, 1));
  }

  // `queries` is n x points x kQueryValues; returns logits, n x points.
  at::Tensor Decode(const at::Tensor& features, const at::Tensor& queries) {
    namespace F = torch::nn::functional;
    const int64_t n = queries.size(0), points = queries.size(1);
    const at::Tensor places = queries.slice(2, 0, 3).view({n, points, 1, 1, 3});
    const at::Tensor sampled = F::grid_sample(features, places,
                                              F::GridSampleFuncOptions()
                                                  .mode(torch::kBilinear)
                                                  .padding_mode(torch::kBorder)
                                                  .align_corners(false))
                                   .view({n, features.size(1), points})
                                   .transpose(1, 2);
    at::Tensor x = torch::cat({sampled, queries}, 2);
    x = torch::relu(hidden_1(x));
    x = torch::relu(hidden_2(x));
    return last(x).squeeze(2);
  }

  std::shared_ptr<Block> first, second, down_8, at_8, down_4, at_4, up_8, up_16;
  torch::nn::Linear squeeze{nullptr}, expand{nullptr};
  torch::nn::Linear hidden_1{nullptr}, hidden_2{nullptr}, last{nullptr};
};

at::Tensor ChannelTensor(const std::vector<int8_t>& channels, int64_t count,
                         const torch::Device& device) {
  return torch::from_blob(const_cast<int8_t*>(channels.data()),
                          {count, kInputChannels, kInputCells, kInputCells, kInputCells},
                          torch::kChar)
      .to(device)
      .to(torch::kFloat)
      .mul_(1.0 / 127.0);
}

at::Tensor FloatTensor(const float* values, at::IntArrayRef shape, const torch::Device& device) {
  return torch::from_blob(const_cast<float*>(values), shape, torch::kFloat)
      .to(device, false, /*copy=*/true);
}

torch::Device DeviceNamed(const std::string& name) {
  CheckInput(name == "cpu" || name == "cuda", "device '" + name + "'; it may be cpu or cuda");
  if (name == "cpu") return torch::kCPU;
  CheckInput(torch::cuda::is_available(),
             "device cuda: this libtorch has none or finds no device; use cpu");
  return torch::kCUDA;
}

// The first four are the view itself, half a turn about z, and two quarter turns.
constexpr int kOrder[kCubeTurns] = {0, 3, 5, 6, 1, 2, 4, 7};

// Mean probabilities of the points over the turned copies of a view. `features` has one row for
// each copy.
std::vector<float> Decoded(Net& net, const at::Tensor& features, const NetworkQuery& query,
                           int turns, const torch::Device& device) {
  std::vector<float> probabilities, queries;
  probabilities.reserve(query.points_C.size());
  for (size_t first = 0; first < query.points_C.size(); first += kChunk) {
    const auto some =
        query.points_C.subspan(first, std::min<size_t>(kChunk, query.points_C.size() - first));
    queries.clear();
    for (const Eigen::Vector3f& p_C : some) AppendQuery(*query.input, p_C, queries);
    const size_t size = queries.size();
    queries.resize(turns * size);
    for (int i = 1; i < turns; ++i) {
      float* copy = queries.data() + i * size;
      std::copy_n(queries.data(), size, copy);
      for (size_t k = 0; k < size; k += kQueryValues) TurnPlace(kOrder[i], copy + k);
    }
    const at::Tensor tensor = FloatTensor(
        queries.data(), {turns, static_cast<int64_t>(some.size()), kQueryValues}, device);
    const at::Tensor values =
        torch::sigmoid(net.Decode(features, tensor)).mean(0).cpu().contiguous();
    const float* begin = values.data_ptr<float>();
    probabilities.insert(probabilities.end(), begin, begin + values.numel());
  }
  return probabilities;
}

}  // namespace

void CompletionNetworkOptions::Visit(SettingsVisitor& v) {
  v.Integer("width_16", width_16, {4, 256}, "channels of the layers with 16^3 cells");
  v.Integer("width_8", width_8, {4, 256}, "channels of the layers with 8^3 cells");
  v.Integer("width_4", width_4, {4, 256}, "channels of the layers with 4^3 cells");
  v.Integer("bottleneck", bottleneck, {4, 4096}, "values that describe the whole cube");
  v.Integer("hidden", hidden, {4, 1024}, "units of each hidden layer of the decoder");
}

struct CompletionNetwork::Impl {
  Impl(const CompletionNetworkOptions& the_options, uint64_t seed, const std::string& name)
      : options(the_options),
        device(DeviceNamed(name)),
        net(Make(the_options, seed, device)),
        adam(net->parameters(), torch::optim::AdamOptions()) {}
  // Weights are drawn on the CPU, so that a seed gives the same weights on every device.
  static std::shared_ptr<Net> Make(const CompletionNetworkOptions& options, uint64_t seed,
                                   const torch::Device& device) {
    torch::manual_seed(seed);
    auto made = std::make_shared<Net>(options);
    made->to(device);
    made->eval();
    return made;
  }
  std::vector<at::Tensor> StatisticTensors() const {
    std::vector<at::Tensor> tensors;
    for (const at::Tensor& buffer : net->buffers()) {
      if (buffer.scalar_type() == torch::kFloat) tensors.push_back(buffer);
    }
    return tensors;
  }

  CompletionNetworkOptions options;
  torch::Device device;
  std::shared_ptr<Net> net;
  torch::optim::Adam adam;
};

CompletionNetwork::CompletionNetwork(const CompletionNetworkOptions& options, uint64_t seed,
                                     const std::string& device) {
  CheckSettings("CompletionNetworkOptions", options);
  impl_ = std::make_unique<Impl>(options, seed, device);
}
CompletionNetwork::~CompletionNetwork() = default;
CompletionNetwork::CompletionNetwork(CompletionNetwork&&) noexcept = default;
CompletionNetwork& CompletionNetwork::operator=(CompletionNetwork&&) noexcept = default;

const CompletionNetworkOptions& CompletionNetwork::options() const { return impl_->options; }

int64_t CompletionNetwork::WeightCount() const {
  int64_t count = 0;
  for (const at::Tensor& parameter : impl_->net->parameters()) count += parameter.numel();
  return count;
}

double CompletionNetwork::TrainStep(const CompletionBatch& batch, double learning_rate) {
  Net& net = *impl_->net;
  SetLearningRate(impl_->adam, learning_rate);
  impl_->adam.zero_grad();
  net.train();
  const at::Tensor channels = ChannelTensor(batch.channels, batch.count, impl_->device);
  const at::Tensor queries =
      FloatTensor(batch.queries.data(), {batch.count, batch.points, kQueryValues}, impl_->device);
  const at::Tensor inside =
      FloatTensor(batch.inside.data(), {batch.count, batch.points}, impl_->device);
  const at::Tensor loss =
      torch::binary_cross_entropy_with_logits(net.Decode(net.Encode(channels), queries), inside);
  loss.backward();
  impl_->adam.step();
  net.eval();
  return loss.item<double>();
}

std::vector<float> CompletionNetwork::Probabilities(const CompletionBatch& batch) const {
  const torch::NoGradGuard no_gradients;
  Net& net = *impl_->net;
  const at::Tensor features = net.Encode(ChannelTensor(batch.channels, batch.count, impl_->device));
  const at::Tensor queries =
      FloatTensor(batch.queries.data(), {batch.count, batch.points, kQueryValues}, impl_->device);
  const at::Tensor values = torch::sigmoid(net.Decode(features, queries)).cpu().contiguous();
  return {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()};
}

std::vector<float> CompletionNetwork::Probabilities(const CompletionInput& input,
                                                    std::span<const Eigen::Vector3f> points_C,
                                                    int turns) const {
  const NetworkQuery query{&input, points_C};
  return std::move(Probabilities(std::span(&query, 1), turns).front());
}

std::vector<std::vector<float>> CompletionNetwork::Probabilities(
    std::span<const NetworkQuery> queries, int turns) const {
  const torch::NoGradGuard no_gradients;
  Net& net = *impl_->net;
  std::vector<std::vector<float>> probabilities;
  for (size_t first = 0; first < queries.size(); first += kViews) {
    const auto some = queries.subspan(first, std::min<size_t>(kViews, queries.size() - first));
    std::vector<int8_t> channels;
    for (const NetworkQuery& query : some) {
      const std::vector<int8_t> own = query.input->Channels();
      for (int i = 0; i < turns; ++i) {
        const std::vector<int8_t> turned = TurnedChannels(own, kOrder[i]);
        channels.insert(channels.end(), turned.begin(), turned.end());
      }
    }
    const int64_t count = turns * static_cast<int64_t>(some.size());
    const at::Tensor features = net.Encode(ChannelTensor(channels, count, impl_->device));
    for (size_t i = 0; i < some.size(); ++i) {
      const int64_t row = turns * static_cast<int64_t>(i);
      probabilities.push_back(
          Decoded(net, features.slice(0, row, row + turns), some[i], turns, impl_->device));
    }
  }
  return probabilities;
}

std::vector<float> CompletionNetwork::Weights() const { return WeightsOf(*impl_->net); }

std::vector<float> CompletionNetwork::Statistics() const {
  std::vector<float> values;
  for (const at::Tensor& tensor : impl_->StatisticTensors()) {
    const at::Tensor plain = tensor.cpu().contiguous();
    values.insert(values.end(), plain.data_ptr<float>(), plain.data_ptr<float>() + plain.numel());
  }
  return values;
}

void CompletionNetwork::SetWeights(std::span<const float> weights,
                                   std::span<const float> statistics) {
  const torch::NoGradGuard no_gradients;
  SetWeightsOf(*impl_->net, weights);
  CheckInput(statistics.size() == Statistics().size(),
             "the number of normalization values does not fit the network");
  const float* next = statistics.data();
  for (at::Tensor tensor : impl_->StatisticTensors()) {
    tensor.copy_(torch::from_blob(const_cast<float*>(next), tensor.sizes(), torch::kFloat));
    next += tensor.numel();
  }
}

std::string CompletionNetwork::TrainingState() const {
  return TrainingStateOf(*impl_->net, impl_->adam);
}

void CompletionNetwork::RestoreTrainingState(const std::string& bytes) {
  RestoreTrainingStateOf(bytes, *impl_->net, impl_->adam);
}

void AppendQuery(const CompletionInput& input, const Eigen::Vector3f& p_C,
                 std::vector<float>& queries) {
  const CompletionCube& cube = input.cube();
  const Eigen::Vector3f place = (p_C - cube.origin_C) * (2 / cube.side_m) - Eigen::Vector3f::Ones();
  queries.insert(queries.end(), place.data(), place.data() + 3);
  const auto facts = input.Facts(p_C);
  queries.insert(queries.end(), facts.begin(), facts.end());
}

}  // namespace pickbed::perception
