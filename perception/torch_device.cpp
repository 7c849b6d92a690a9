#include "perception/torch_device.h"

#include <torch/cuda.h>

#include <cstdlib>
#include <string>

#include "scenes/check.h"

namespace pickbed {
namespace {

torch::Device Chosen() {
  const char* value = std::getenv("PICKBED_DEVICE");
  const std::string wish = value == nullptr || *value == '\0' ? "auto" : value;
  CheckInput(wish == "auto" || wish == "cpu" || wish == "cuda",
             "PICKBED_DEVICE is '" + wish + "'; it may be auto, cpu or cuda");
  if (wish == "cpu") return torch::kCPU;
  const bool there = torch::cuda::is_available();
  CheckInput(there || wish == "auto",
             "PICKBED_DEVICE asks for cuda, but this libtorch has none or finds no device");
  return there ? torch::kCUDA : torch::kCPU;
}

}  // namespace

torch::Device NetworkDevice() {
  static const torch::Device device = Chosen();
  return device;
}

}  // namespace pickbed
