#include "perception/completion/completion_network.h"

#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <torch/cuda.h>
#include <torch/optim/adam.h>
#include <torch/types.h>
#include <torch/utils.h>

#include <algorithm>
#include <numeric>

#include "perception/completion_networks/completion_net.h"
#include "perception/networks/fixed_layers.h"
#include "perception/networks/torch_runtime.h"
#include "scenes/base/error.h"
#include "scenes/base/parallel.h"
#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

// Points decoded at once.
constexpr int64_t kChunk = 8192;
// Views encoded at once.
constexpr int64_t kViews = 16;

at::Tensor ChannelTensor(std::span<const int8_t> channels, int64_t count,
                         const torch::Device& device) {
  const int64_t each = static_cast<int64_t>(channels.size()) / (count * kInputVolume);
  return torch::from_blob(const_cast<int8_t*>(channels.data()),
                          {count, each, kInputCells, kInputCells, kInputCells}, torch::kChar)
      .to(device)
      .to(torch::kFloat)
      .mul_(1.0 / 127.0);
}

at::Tensor FloatTensor(const float* values, at::IntArrayRef shape, const torch::Device& device) {
  return torch::from_blob(const_cast<float*>(values), shape, torch::kFloat)
      .to(device, false, /*copy=*/true);
}

CompletionViews ViewTensors(std::span<const int8_t> channels, std::span<const float> images,
                            int64_t count, const torch::Device& device) {
  return {ChannelTensor(channels, count, device),
          FloatTensor(images.data(), {count, kImageChannels, kImagePixels, kImagePixels}, device)};
}

const CompletionNetRow& RowOf(const CompletionNetworkOptions& options) {
  for (const CompletionNetRow& row : CompletionNetTable()) {
    if (row.name == options.kind) return row;
  }
  throw InputError(
      UnknownNameMessage("kind of completion network", options.kind, CompletionKinds()));
}

torch::Device DeviceNamed(const std::string& name) {
  CheckInput(name == "cpu" || name == "cuda", "device '" + name + "'; it may be cpu or cuda");
  if (name == "cpu") return torch::kCPU;
  CheckInput(torch::cuda::is_available(),
             "device cuda: this libtorch has none or finds no device; use cpu");
  // Products with 10 bits of mantissa are enough for training and take a fraction of the time.
  at::globalContext().setAllowTF32CuBLAS(true);
  at::globalContext().setAllowTF32CuDNN(true);
  at::globalContext().setBenchmarkCuDNN(true);
  return torch::kCUDA;
}

// The first four are the view itself, half a turn about z, and two quarter turns.
constexpr int kOrder[kCubeTurns] = {0, 3, 5, 6, 1, 2, 4, 7};

// Mean probabilities of the points over the turned copies of a view. `code` has one row for each
// copy.
std::vector<float> Decoded(CompletionNet& net, const CompletionCode& code,
                           const NetworkQuery& query, int turns, const torch::Device& device) {
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
      for (size_t k = 0; k < size; k += kQueryValues) TurnPlaces(kOrder[i], copy + k);
    }
    const at::Tensor tensor = FloatTensor(
        queries.data(), {turns, static_cast<int64_t>(some.size()), kQueryValues}, device);
    const at::Tensor values = ApplyLogistic(net.Decode(code, tensor)).cpu().contiguous();
    const float* const by_turn = values.data_ptr<float>();
    for (size_t i = 0; i < some.size(); ++i) {
      float sum = 0;
      for (int turn = 0; turn < turns; ++turn) sum += by_turn[turn * some.size() + i];
      probabilities.push_back(sum / static_cast<float>(turns));
    }
  }
  return probabilities;
}

// Means and variances of the normalizations.
std::vector<at::Tensor> FloatBuffers(const CompletionNet& net) {
  std::vector<at::Tensor> tensors;
  for (const at::Tensor& buffer : net.buffers()) {
    if (buffer.scalar_type() == torch::kFloat) tensors.push_back(buffer);
  }
  return tensors;
}

void CopyTensors(const std::vector<at::Tensor>& from, const std::vector<at::Tensor>& to) {
  for (size_t i = 0; i < from.size(); ++i) to[i].copy_(from[i]);
}

// Views of a batch, from `begin` to before `end`.
struct ViewRange {
  int begin, end;
};

}  // namespace

struct CompletionNetwork::Impl {
  Impl(const CompletionNetworkOptions& the_options, uint64_t seed, const std::string& name)
      : options(the_options),
        device(DeviceNamed(name)),
        net(Make(the_options, seed, device)),
        adam(net->parameters(), torch::optim::AdamOptions()) {}
  // Weights are drawn on the CPU, so that a seed gives the same weights on every device.
  static std::shared_ptr<CompletionNet> Make(const CompletionNetworkOptions& options, uint64_t seed,
                                             const torch::Device& device) {
    torch::manual_seed(seed);
    auto made = RowOf(options).make(options);
    made->to(device);
    made->eval();
    return made;
  }
  std::vector<at::Tensor> StatisticTensors() const { return FloatBuffers(*net); }
  CompletionNet& Replica(int index) { return index == 0 ? *net : *copies[index - 1]; }
  // Gives all replicas the weights and statistics of the network.
  void SpreadWeights(int replicas);
  // Gives the network the sum of the gradients of all replicas, and the mean of their statistics.
  // - shares: share of the views of the batch that each replica has; their sum is 1
  void CollectGradients(std::span<const double> shares);
  // Computes the gradient of the mean loss of some views, times `share`. Returns the loss.
  double Backward(const CompletionBatch& batch, ViewRange range, double share,
                  CompletionNet& replica);

  CompletionNetworkOptions options;
  torch::Device device;
  std::shared_ptr<CompletionNet> net;
  torch::optim::Adam adam;
  std::vector<std::shared_ptr<CompletionNet>> copies;  // the other replicas
};

void CompletionNetwork::Impl::SpreadWeights(int replicas) {
  const torch::NoGradGuard no_gradients;
  while (static_cast<int>(copies.size()) + 1 < replicas) copies.push_back(Make(options, 0, device));
  for (int i = 1; i < replicas; ++i) {
    CopyTensors(net->parameters(), Replica(i).parameters());
    CopyTensors(FloatBuffers(*net), FloatBuffers(Replica(i)));
  }
}

void CompletionNetwork::Impl::CollectGradients(std::span<const double> shares) {
  const torch::NoGradGuard no_gradients;
  const std::vector<at::Tensor> weights = net->parameters(), statistics = FloatBuffers(*net);
  for (const at::Tensor& values : statistics) values.mul_(shares.front());
  for (size_t i = 1; i < shares.size(); ++i) {
    CompletionNet& replica = Replica(static_cast<int>(i));
    const std::vector<at::Tensor> others = replica.parameters();
    for (size_t k = 0; k < weights.size(); ++k) {
      if (others[k].grad().defined()) weights[k].mutable_grad().add_(others[k].grad());
    }
    const std::vector<at::Tensor> their_statistics = FloatBuffers(replica);
    for (size_t k = 0; k < statistics.size(); ++k) {
      statistics[k].add_(their_statistics[k], shares[i]);
    }
  }
}

double CompletionNetwork::Impl::Backward(const CompletionBatch& batch, ViewRange range,
                                         double share, CompletionNet& replica) {
  replica.zero_grad();
  replica.train();
  const int64_t count = range.end - range.begin;
  const auto rows = [&](const auto& values) {
    return std::span(values).subspan(values.size() / batch.count * range.begin,
                                     values.size() / batch.count * count);
  };
  const std::span<const float> queries = rows(batch.queries);
  CompletionTensors step;
  step.first = range.begin;
  step.views = ViewTensors(rows(batch.channels), rows(batch.images), count, device);
  step.queries = FloatTensor(queries.data(), {count, batch.points, kQueryValues}, device);
  step.inside = FloatTensor(rows(batch.inside).data(), {count, batch.points}, device);
  if (RowOf(options).needs_volumes) {
    step.volumes = ChannelTensor(rows(batch.volumes), count, device);
    // Random numbers follow from the data, so that a resumed training draws the same ones.
    step.seed = HashBytes(queries.data(), queries.size_bytes());
  }
  const at::Tensor loss = replica.Loss(step);
  (loss * share).backward();
  replica.eval();
  return loss.item<double>();
}

CompletionNetwork::CompletionNetwork(const CompletionNetworkOptions& options, uint64_t seed,
                                     const std::string& device) {
  CheckSettings("CompletionNetworkOptions", options);
  impl_ = std::make_unique<Impl>(options, seed, device);
}
CompletionNetwork::~CompletionNetwork() = default;
CompletionNetwork::CompletionNetwork(CompletionNetwork&&) noexcept = default;
CompletionNetwork& CompletionNetwork::operator=(CompletionNetwork&&) noexcept = default;

bool CompletionNetwork::NeedsVolumes(const CompletionNetworkOptions& options) {
  return RowOf(options).needs_volumes;
}

const CompletionNetworkOptions& CompletionNetwork::options() const { return impl_->options; }

double CompletionNetwork::TrainStep(const CompletionBatch& batch, double learning_rate,
                                    int replicas) {
  CheckInput(batch.count > 0, "a training step needs at least one view");
  replicas = std::clamp(replicas, 1, batch.count);
  SetLearningRate(impl_->adam, learning_rate);
  impl_->SpreadWeights(replicas);
  std::vector<double> losses(replicas), shares(replicas);
  ForRanges(replicas, replicas, [&](int first, int last) {
    // libtorch sets the number of threads of a layer in each thread that calls it.
    at::init_num_threads();
    for (int i = first; i < last; ++i) {
      const ViewRange range{batch.count * i / replicas, batch.count * (i + 1) / replicas};
      shares[i] = static_cast<double>(range.end - range.begin) / batch.count;
      losses[i] = shares[i] * impl_->Backward(batch, range, shares[i], impl_->Replica(i));
    }
  });
  impl_->CollectGradients(shares);
  impl_->adam.step();
  return std::accumulate(losses.begin(), losses.end(), 0.0);
}

std::vector<float> CompletionNetwork::Probabilities(const CompletionBatch& batch) const {
  const torch::NoGradGuard no_gradients;
  CompletionNet& net = *impl_->net;
  const CompletionCode code =
      net.Encode(ViewTensors(batch.channels, batch.images, batch.count, impl_->device));
  const at::Tensor queries =
      FloatTensor(batch.queries.data(), {batch.count, batch.points, kQueryValues}, impl_->device);
  const at::Tensor values = ApplyLogistic(net.Decode(code, queries)).cpu().contiguous();
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
  CompletionNet& net = *impl_->net;
  std::vector<std::vector<float>> probabilities;
  for (size_t first = 0; first < queries.size(); first += kViews) {
    const auto some = queries.subspan(first, std::min<size_t>(kViews, queries.size() - first));
    const int64_t count = turns * static_cast<int64_t>(some.size());
    std::vector<int8_t> channels(count * kInputChannels * kInputVolume);
    std::vector<float> images(count * kImageChannels * kImageArea);
    int8_t* next_channels = channels.data();
    float* next_image = images.data();
    for (const NetworkQuery& query : some) {
      const std::vector<int8_t> own = query.input->Channels();
      const std::vector<float> own_image = query.input->ImageChannels();
      for (int i = 0; i < turns; ++i) {
        TurnChannels(own, kOrder[i], next_channels);
        TurnImage(own_image, kOrder[i], next_image);
        next_channels += own.size();
        next_image += own_image.size();
      }
    }
    const CompletionCode code = net.Encode(ViewTensors(channels, images, count, impl_->device));
    for (size_t i = 0; i < some.size(); ++i) {
      const int64_t row = turns * static_cast<int64_t>(i);
      probabilities.push_back(
          Decoded(net, code.Rows(row, row + turns), some[i], turns, impl_->device));
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
  const Eigen::Vector2f image_place = input.ImagePlace(p_C);
  queries.insert(queries.end(), image_place.data(), image_place.data() + 2);
  const auto facts = input.Facts(p_C);
  queries.insert(queries.end(), facts.begin(), facts.end());
}

}  // namespace pickbed::perception
