#pragma once

// Interface of networks for local patches: each computes descriptors and its own training loss. A
// new network is one file here and one row in patch_network.cpp. libtorch's headers are included
// only by .cpp files.

#include <memory>
#include <span>

#include "perception/networks/descriptor_network.h"

namespace at {
class Tensor;
}
namespace torch::nn {
class Module;
}

namespace pickbed::perception {

struct TrainingTensors;  // networks/training_tensors.h

// A network for patches.
class PatchNetwork {
 public:
  virtual ~PatchNetwork() = default;
  // Maps patches, count x 4 x 32 x 32 floats in [-1, 1], to count x length descriptors. They have
  // unit norm if the row's unit_rows is set.
  virtual at::Tensor Forward(const at::Tensor& patches) = 0;
  // Returns the training loss: a scalar with gradient. `options` is for losses that compare
  // descriptors; the options of other losses are in NetworkOptions.
  virtual at::Tensor Loss(const TrainingTensors& batch, const LossOptions& options) = 0;
  // Returns poses, count x object_count x kPoseValues, see pose_targets.h. Throws std::logic_error
  // if the network regresses none.
  virtual at::Tensor Poses(const at::Tensor& patches);
  virtual torch::nn::Module& module() = 0;  // holds the weights
  virtual double MultiplyAdds() const = 0;  // number of operations to describe one patch
};

// One row of the table of networks.
struct PatchNetworkRow {
  const char* name;
  const char* help;
  std::unique_ptr<PatchNetwork> (*make)(const NetworkOptions& options, int object_count);
  bool unit_rows = true;   // descriptors have unit norm
  bool regresses = false;  // it also regresses poses of the `object_count` objects passed to make
  PatchChannels (*channels)(const NetworkOptions& options) = nullptr;  // null: depth and normals
};

// Returns all networks.
std::span<const PatchNetworkRow> PatchNetworkTable();
// Throws InputError with the nearest known name if there is no such network.
const PatchNetworkRow& FindPatchNetwork(const std::string& name);

// Entries of the table; `object_count` is the number of objects whose poses a network regresses.
std::unique_ptr<PatchNetwork> MakeConvolutionalNetwork(const NetworkOptions& options,
                                                       int object_count);
// Returns the convolutional autoencoder of estimator kehl.
std::unique_ptr<PatchNetwork> MakeAutoencoder(const NetworkOptions& options, int object_count);
// Returns the network that is trained on pairs of patches and regresses poses.
std::unique_ptr<PatchNetwork> MakeSiameseRegression(const NetworkOptions& options,
                                                    int object_count);
// Returns the channels of the patches that the autoencoder reads.
PatchChannels AutoencoderChannels(const NetworkOptions& options);

}  // namespace pickbed::perception
