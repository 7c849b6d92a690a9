#include "perception/torch_network.h"

#include <torch/torch.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "perception/networks/patch_network.h"
#include "perception/patch.h"
#include "perception/torch_device.h"
#include "perception/torch_weights.h"
#include "scenes/check.h"
#include "scenes/parallel.h"

namespace pickbed {
namespace {

// Patches described in one call; more does not fit the caches.
constexpr int64_t kChunk = 64;

std::unique_ptr<PatchNetwork> MakeNetwork(const NetworkOptions& options, uint64_t seed) {
  std::vector<std::string> known;
  for (const PatchNetworkRow& row : PatchNetworkTable()) {
    known.push_back(row.name);
    if (options.kind != row.name) continue;
    at::set_num_threads(1);
    torch::manual_seed(seed);
    return row.make(options.descriptor);
  }
  throw InputError(UnknownNameMessage("network", options.kind, known));
}

at::Tensor ToTensor(std::span<const int8_t> patches, const torch::Device& device) {
  const int64_t count = static_cast<int64_t>(patches.size()) / kPatchValues;
  // from_blob takes no const pointer; the values are copied by the conversion.
  const at::Tensor bytes =
      torch::from_blob(const_cast<int8_t*>(patches.data()),
                       {count, kPatchChannels, kPatchPixels, kPatchPixels}, torch::kChar);
  // Channels last: oneDNN's convolutions of so few channels take half the time in that layout.
  return bytes.to(device, torch::kFloat, false, false, at::MemoryFormat::ChannelsLast)
      .mul_(1.0 / 127.0);
}

}  // namespace

void NetworkOptions::Visit(SettingsVisitor& v) {
  std::vector<std::string> kinds;
  for (const PatchNetworkRow& row : PatchNetworkTable()) kinds.push_back(row.name);
  v.Text("kind", kind, kinds, "the network that describes a patch");
  v.Integer("descriptor", descriptor, {2, 1024}, "length of the descriptor");
}

struct DescriptorNetwork::Impl {
  Impl(const NetworkOptions& options, uint64_t seed)
      : options(options),
        device(NetworkDevice()),
        network(OnDevice(MakeNetwork(options, seed), device)),
        adam(network->module().parameters(), torch::optim::AdamOptions()) {}
  // Weights are drawn on the CPU, so that a seed means the same everywhere. Adam is made after the
  // move, since it holds on to the tensors.
  static std::unique_ptr<PatchNetwork> OnDevice(std::unique_ptr<PatchNetwork> network,
                                                const torch::Device& device) {
    network->module().to(device);
    return network;
  }
  NetworkOptions options;
  torch::Device device;
  std::unique_ptr<PatchNetwork> network;
  torch::optim::Adam adam;
};

DescriptorNetwork::DescriptorNetwork(const NetworkOptions& options, uint64_t seed)
    : impl_(std::make_unique<Impl>(options, seed)) {}
DescriptorNetwork::~DescriptorNetwork() = default;
DescriptorNetwork::DescriptorNetwork(DescriptorNetwork&&) noexcept = default;
DescriptorNetwork& DescriptorNetwork::operator=(DescriptorNetwork&&) noexcept = default;

const NetworkOptions& DescriptorNetwork::options() const { return impl_->options; }

double DescriptorNetwork::MultiplyAdds() const { return impl_->network->MultiplyAdds(); }

std::vector<float> DescriptorNetwork::Describe(std::span<const int8_t> patches, int threads) const {
  const int64_t count = static_cast<int64_t>(patches.size()) / kPatchValues;
  std::vector<float> descriptors(count * length());
  const auto describe = [&](int64_t first) {
    const int64_t size = std::min(kChunk, count - first);
    const at::Tensor rows =
        impl_->network
            ->Forward(
                ToTensor(patches.subspan(first * kPatchValues, size * kPatchValues), impl_->device))
            .cpu()
            .contiguous();
    std::copy_n(rows.data_ptr<float>(), rows.numel(), descriptors.begin() + first * length());
  };
  const int chunks = static_cast<int>((count + kChunk - 1) / kChunk);
  ForRanges(chunks, threads, [&](int begin, int end) {
    const torch::InferenceMode no_gradients;  // of this thread
    for (int chunk = begin; chunk < end; ++chunk) describe(chunk * kChunk);
  });
  return descriptors;
}

double DescriptorNetwork::TrainStep(const TrainingBatch& batch, const LossOptions& loss,
                                    double learning_rate) {
  SetLearningRate(impl_->adam, learning_rate);
  const at::Tensor both =
      torch::cat({ToTensor(batch.anchors, impl_->device), ToTensor(batch.codes, impl_->device)});
  const at::Tensor distance = torch::from_blob(const_cast<float*>(batch.pose_distance.data()),
                                               {batch.count, batch.count}, torch::kFloat)
                                  .to(impl_->device);
  impl_->adam.zero_grad();
  const at::Tensor rows = impl_->network->Forward(both);
  const at::Tensor value =
      DescriptorLoss(rows.slice(0, 0, batch.count), rows.slice(0, batch.count), distance, loss);
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
  RestoreTrainingStateOf(bytes, impl_->device, impl_->network->module(), impl_->adam);
}

double SgemmRate() {
  constexpr int64_t kSide = 512;
  constexpr int kTries = 12;
  const torch::InferenceMode no_gradients;
  const at::Tensor a = torch::rand({kSide, kSide}), b = torch::rand({kSide, kSide});
  double best_s = std::numeric_limits<double>::max();
  for (int i = 0; i < kTries; ++i) {
    const auto start = std::chrono::steady_clock::now();
    torch::mm(a, b);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    best_s = std::min(best_s, seconds.count());
  }
  return kSide * kSide * kSide / best_s;
}

}  // namespace pickbed
