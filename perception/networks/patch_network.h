#pragma once

// Networks of local patches: each gives descriptors and knows what it is taught. Adding one is one
// file here and one row in patch_network.cpp. Only .cpp files see libtorch's headers.

#include <memory>
#include <span>

#include "perception/torch_network.h"

namespace at {
class Tensor;
}
namespace torch::nn {
class Module;
}

namespace pickbed {

struct TrainingTensors;  // networks/training_tensors.h

class PatchNetwork {
 public:
  virtual ~PatchNetwork() = default;
  // patches: count x 4 x 32 x 32 float in [-1, 1]; result: count x length, see the row's unit_rows.
  virtual at::Tensor Forward(const at::Tensor& patches) = 0;
  // What a step of training lowers: a scalar with gradient. `options` are those of the loss that
  // compares descriptors; a network of another loss has its options among NetworkOptions.
  virtual at::Tensor Loss(const TrainingTensors& batch, const LossOptions& options) = 0;
  // Of networks whose row regresses: count x parts x kPoseValues, see pose_targets.h.
  virtual at::Tensor Poses(const at::Tensor& patches);
  virtual torch::nn::Module& module() = 0;  // its weights
  virtual double MultiplyAdds() const = 0;  // to describe one patch
};

struct PatchNetworkRow {
  const char* name;
  const char* help;
  std::unique_ptr<PatchNetwork> (*make)(const NetworkOptions& options, int parts);
  bool unit_rows = true;   // descriptors have unit length
  bool regresses = false;  // it gives poses too, of as many parts as it was made for
  PatchChannels (*channels)(const NetworkOptions& options) = nullptr;  // null: depth and normals
};

std::span<const PatchNetworkRow> PatchNetworkTable();
// Throws InputError with the nearest known name.
const PatchNetworkRow& FindPatchNetwork(const std::string& name);

std::unique_ptr<PatchNetwork> MakeConvolutionalNetwork(const NetworkOptions& options, int parts);
std::unique_ptr<PatchNetwork> MakeAutoencoder(const NetworkOptions& options, int parts);
std::unique_ptr<PatchNetwork> MakeSiameseRegression(const NetworkOptions& options, int parts);
PatchChannels AutoencoderChannels(const NetworkOptions& options);

}  // namespace pickbed
