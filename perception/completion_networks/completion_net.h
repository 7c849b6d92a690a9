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

// Tensors of a training step.
struct CompletionTensors {
  at::Tensor channels;  // n x kInputChannels x 32^3
  at::Tensor queries;   // n x points x kQueryValues
  at::Tensor inside;    // n x points, 1 = inside
  at::Tensor volumes;   // n x 1 x 32^3, 1 = inside; undefined for kinds that need none
  uint64_t seed = 0;    // for random numbers of the loss
};

struct CompletionNet : torch::nn::Module {
  // Returns the code of each view: n x features x cells^3. `channels` is n x kInputChannels x 32^3.
  // The code of a view does not depend on the other views.
  virtual at::Tensor Encode(const at::Tensor& channels) = 0;
  // Returns the logit of each query, n x points. `queries` is n x points x kQueryValues.
  virtual at::Tensor Decode(const at::Tensor& code, const at::Tensor& queries) = 0;
  // Returns the loss of a training step.
  virtual at::Tensor Loss(const CompletionTensors& step) = 0;
};

// Returns the values of a code at the places of queries, trilinear: n x points x features.
at::Tensor SampledCode(const at::Tensor& code, const at::Tensor& queries);

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
