#pragma once

// Networks that turn patches into descriptors. Adding one is one file here and one row in
// patch_network.cpp. Only the .cpp files see libtorch's headers.

#include <memory>
#include <span>

namespace at {
class Tensor;
}
namespace torch::nn {
class Module;
}

namespace pickbed {

class PatchNetwork {
 public:
  virtual ~PatchNetwork() = default;
  // patches: count x 4 x 32 x 32 float in [-1, 1]; result: count x length, rows of unit length.
  virtual at::Tensor Forward(const at::Tensor& patches) = 0;
  virtual torch::nn::Module& module() = 0;  // its weights
  virtual double MultiplyAdds() const = 0;  // to describe one patch
};

struct PatchNetworkRow {
  const char* name;
  const char* help;
  std::unique_ptr<PatchNetwork> (*make)(int descriptor_length);
};

std::span<const PatchNetworkRow> PatchNetworkTable();

std::unique_ptr<PatchNetwork> MakeConvolutionalNetwork(int descriptor_length);

}  // namespace pickbed
