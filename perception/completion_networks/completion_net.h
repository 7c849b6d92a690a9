#pragma once

// Kinds of completion networks, behind one interface of libtorch modules, and the table of these
// kinds. CompletionNetwork (completion/completion_network.h) trains and queries them.

#include <torch/nn/module.h>
#include <torch/types.h>

#include <memory>
#include <string>
#include <vector>

#include "perception/completion_networks/network_options.h"

namespace pickbed::perception {

// Input of n views.
struct CompletionViews {
  at::Tensor channels;  // n x kInputChannels x 32^3
  at::Tensor images;    // n x kImageChannels x 64^2
};

// Codes of n views.
struct CompletionCode {
  at::Tensor volume;  // n x features x cells^3
  at::Tensor image;   // n x features x 1 x 64^2; undefined for kinds without image
  // Returns the codes of the views from `first` to before `last`.
  CompletionCode Rows(int64_t first, int64_t last) const;
};

// Tensors of a training step.
struct CompletionTensors {
  CompletionViews views;
  at::Tensor queries;  // n x points x kQueryValues
  at::Tensor inside;   // n x points, 1 = inside
  at::Tensor volumes;  // n x 1 x 32^3, 1 = inside; undefined for kinds that need none
  uint64_t seed = 0;   // for random numbers of the loss
  int64_t first = 0;   // index of the first view in the batch
};

struct CompletionNet : torch::nn::Module {
  // Returns the code of each view. It does not depend on the other views.
  virtual CompletionCode Encode(const CompletionViews& views) = 0;
  // Returns the logit of each query, n x points. `queries` is n x points x kQueryValues.
  virtual at::Tensor Decode(const CompletionCode& code, const at::Tensor& queries) = 0;
  // Returns the loss of a training step.
  virtual at::Tensor Loss(const CompletionTensors& step) = 0;
};

// Returns the values of a volume (n x features x z x y x x) at places (n x points x 3, from -1 to 1
// along x, y and z), trilinear: n x points x features.
at::Tensor SampledCode(const at::Tensor& volume, const at::Tensor& places);

struct CompletionNetRow {
  const char* name;
  const char* help;
  bool needs_volumes;  // CompletionTensors::volumes
  std::shared_ptr<CompletionNet> (*make)(const CompletionNetworkOptions& options);
};
// Returns all kinds; the first is the default.
const std::vector<CompletionNetRow>& CompletionNetTable();

std::shared_ptr<CompletionNet> MakeImplicitNet(const CompletionNetworkOptions& options);
std::shared_ptr<CompletionNet> MakeVolumeVae(const CompletionNetworkOptions& options);

}  // namespace pickbed::perception
