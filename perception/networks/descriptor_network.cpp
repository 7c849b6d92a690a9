#include "perception/networks/descriptor_network.h"

#include <torch/optim/adam.h>
#include <torch/types.h>
#include <torch/utils.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "perception/features/patch.h"
#include "perception/features/pose_targets.h"
#include "perception/networks/patch_network.h"
#include "perception/networks/torch_runtime.h"
#include "perception/networks/training_tensors.h"
#include "scenes/base/error.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

// Patches per forward pass; more do not fit the CPU caches.
constexpr int64_t kChunk = 64;

std::unique_ptr<PatchNetwork> MakeNetwork(const NetworkOptions& options, uint64_t seed,
                                          int object_count) {
  const PatchNetworkRow& row = FindPatchNetwork(options.kind);
  at::set_num_threads(1);
  torch::manual_seed(seed);
  return row.make(options, object_count);
}

at::Tensor ToTensor(std::span<const int8_t> patches, const torch::Device& device,
                    at::MemoryFormat layout = at::MemoryFormat::Contiguous) {
  const int64_t count = static_cast<int64_t>(patches.size()) / kPatchValues;
  // from_blob takes no const pointer; the values are copied by the conversion.
  const at::Tensor bytes =
      torch::from_blob(const_cast<int8_t*>(patches.data()),
                       {count, kPatchChannels, kPatchPixels, kPatchPixels}, torch::kChar);
  return bytes.to(device, torch::kFloat, false, false, layout).mul_(1.0 / 127.0);
}

// Copies plain values; from_blob takes no const pointer.
template <typename Value>
at::Tensor ToTensor(const std::vector<Value>& values, at::IntArrayRef shape,
                    const torch::Device& device) {
  return torch::from_blob(const_cast<Value*>(values.data()), shape,
                          c10::CppTypeToScalarType<Value>::value)
      .to(device, false, /*copy=*/true);
}

TrainingTensors ToTensors(const TrainingBatch& batch, const torch::Device& device) {
  // In the channels-last layout, oneDNN's convolutions of so few channels take half the time.
  constexpr at::MemoryFormat kLayout = at::MemoryFormat::ChannelsLast;
  TrainingTensors tensors;
  tensors.patches = torch::cat(
      {ToTensor(batch.anchors, device, kLayout), ToTensor(batch.codes, device, kLayout)});
  tensors.pose_distance = ToTensor(batch.pose_distance, {batch.count, batch.count}, device);
  if (batch.objects.empty()) return tensors;
  const int64_t rows = 2 * batch.count;
  tensors.objects = ToTensor(batch.objects, {rows}, device);
  tensors.rotations = ToTensor(batch.rotations, {rows, batch.variants, 4}, device);
  tensors.centers = ToTensor(batch.centers, {rows, 3}, device);
  return tensors;
}

}  // namespace

void NetworkOptions::Visit(SettingsVisitor& v) {
  std::vector<std::string> kinds;
  for (const PatchNetworkRow& row : PatchNetworkTable()) kinds.push_back(row.name);
  v.Text("kind", kind, kinds, "kind of the network that describes a patch");
  v.Integer("descriptor", descriptor, {2, 1024}, "length of the descriptor");
  v.Group(
      "autoencoder", [&](SettingsVisitor& g) { autoencoder.Visit(g); },
      "settings of kind autoencoder");
  v.Group(
      "regression", [&](SettingsVisitor& g) { regression.Visit(g); },
      "settings of kind siamese_regression");
}

PatchChannels ChannelsOf(const NetworkOptions& options) {
  const PatchNetworkRow& row = FindPatchNetwork(options.kind);
  return row.channels ? row.channels(options) : PatchChannels::kDepthNormals;
}

struct DescriptorNetwork::Impl {
  Impl(const NetworkOptions& options, uint64_t seed, int object_count)
      : options(options),
        object_count(object_count),
        device(NetworkDevice()),
        network(OnDevice(MakeNetwork(options, seed, object_count), device)),
        adam(network->module().parameters(), torch::optim::AdamOptions()) {}
  // Weights are drawn on the CPU, so that a seed gives the same weights on every device. Adam is
  // made after the move, because it keeps the tensors.
  static std::unique_ptr<PatchNetwork> OnDevice(std::unique_ptr<PatchNetwork> network,
                                                const torch::Device& device) {
    network->module().to(device);
    return network;
  }
  // Applies `compute` to all patches and returns `width` values per patch.
  template <typename Compute>
  std::vector<float> ForAll(std::span<const int8_t> patches, int64_t width, int threads,
                            const Compute& compute) const;

  NetworkOptions options;
  int object_count;
  torch::Device device;
  std::unique_ptr<PatchNetwork> network;
  torch::optim::Adam adam;
};

template <typename Compute>
std::vector<float> DescriptorNetwork::Impl::ForAll(std::span<const int8_t> patches, int64_t width,
                                                   int threads, const Compute& compute) const {
  const int64_t count = static_cast<int64_t>(patches.size()) / kPatchValues;
  std::vector<float> values(count * width);
  const auto chunk_from = [&](int64_t first) {
    const int64_t size = std::min(kChunk, count - first);
    const at::Tensor rows =
        compute(ToTensor(patches.subspan(first * kPatchValues, size * kPatchValues), device))
            .cpu()
            .contiguous();
    std::copy_n(rows.template data_ptr<float>(), rows.numel(), values.begin() + first * width);
  };
  const int chunks = static_cast<int>((count + kChunk - 1) / kChunk);
  ForRanges(chunks, threads, [&](int begin, int end) {
    const torch::InferenceMode no_gradients;  // applies to the current thread only
    for (int chunk = begin; chunk < end; ++chunk) chunk_from(chunk * kChunk);
  });
  return values;
}

DescriptorNetwork::DescriptorNetwork(const NetworkOptions& options, uint64_t seed,
                                     int object_count) {
  CheckSettings("NetworkOptions", options);
  impl_ = std::make_unique<Impl>(options, seed, object_count);
}
DescriptorNetwork::~DescriptorNetwork() = default;
DescriptorNetwork::DescriptorNetwork(DescriptorNetwork&&) noexcept = default;
DescriptorNetwork& DescriptorNetwork::operator=(DescriptorNetwork&&) noexcept = default;

const NetworkOptions& DescriptorNetwork::options() const { return impl_->options; }

double DescriptorNetwork::MultiplyAdds() const { return impl_->network->MultiplyAdds(); }

int DescriptorNetwork::object_count() const { return impl_->object_count; }

bool DescriptorNetwork::regresses() const { return FindPatchNetwork(options().kind).regresses; }

std::vector<float> DescriptorNetwork::Describe(std::span<const int8_t> patches, int threads) const {
  return impl_->ForAll(patches, length(), threads,
                       [&](const at::Tensor& some) { return impl_->network->Forward(some); });
}

std::vector<float> DescriptorNetwork::Regress(std::span<const int8_t> patches, int threads) const {
  return impl_->ForAll(patches, static_cast<int64_t>(impl_->object_count) * kPoseValues, threads,
                       [&](const at::Tensor& some) { return impl_->network->Poses(some); });
}

double DescriptorNetwork::TrainStep(const TrainingBatch& batch, const LossOptions& loss,
                                    double learning_rate) {
  SetLearningRate(impl_->adam, learning_rate);
  impl_->adam.zero_grad();
  const at::Tensor value = impl_->network->Loss(ToTensors(batch, impl_->device), loss);
  value.backward();
  impl_->adam.step();
  return value.item<double>();
}

std::vector<float> DescriptorNetwork::Weights() const {
  return WeightsOf(impl_->network->module());
}

void DescriptorNetwork::SetWeights(std::span<const float> weights) {
  SetWeightsOf(impl_->network->module(), weights);
}

std::string DescriptorNetwork::TrainingState() const {
  return TrainingStateOf(impl_->network->module(), impl_->adam);
}

void DescriptorNetwork::RestoreTrainingState(const std::string& bytes) {
  RestoreTrainingStateOf(bytes, impl_->network->module(), impl_->adam);
}

PatchVoter VoterOf(const DescriptorNetwork& network, int threads) {
  PatchVoter voter;
  voter.channels = network.channels();
  voter.describe = [&network, threads](std::span<const int8_t> patches) {
    return network.Describe(patches, threads);
  };
  if (!network.regresses()) return voter;
  voter.object_count = network.object_count();
  voter.regress = [&network, threads](std::span<const int8_t> patches) {
    return network.Regress(patches, threads);
  };
  return voter;
}

double SgemmRate() {
  constexpr int64_t kSide = 512;
  constexpr int kMaxSamples = 12;
  const torch::InferenceMode no_gradients;
  const at::Tensor a = torch::rand({kSide, kSide}), b = torch::rand({kSide, kSide});
  double best_s = std::numeric_limits<double>::max();
  for (int i = 0; i < kMaxSamples; ++i) {
    const auto start = std::chrono::steady_clock::now();
    torch::mm(a, b);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    best_s = std::min(best_s, seconds.count());
  }
  return kSide * kSide * kSide / best_s;
}

}  // namespace pickbed::perception
