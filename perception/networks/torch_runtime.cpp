#include "perception/networks/torch_runtime.h"

#include <torch/cuda.h>
#include <torch/serialize.h>

#include <cstdlib>
#include <sstream>
#include <string>

#include "scenes/base/error.h"

namespace pickbed::perception {
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

std::vector<float> WeightsOf(const torch::nn::Module& module) {
  std::vector<float> weights;
  for (const at::Tensor& parameter : module.parameters()) {
    const at::Tensor values = parameter.detach().cpu().contiguous();
    weights.insert(weights.end(), values.data_ptr<float>(),
                   values.data_ptr<float>() + values.numel());
  }
  return weights;
}

void SetWeightsOf(torch::nn::Module& module, std::span<const float> weights) {
  const torch::NoGradGuard no_gradients;
  const std::vector<at::Tensor> parameters = module.parameters();
  int64_t needed = 0;
  for (const at::Tensor& parameter : parameters) needed += parameter.numel();
  CheckInput(needed == static_cast<int64_t>(weights.size()),
             "the network has " + std::to_string(needed) + " weights, the file holds " +
                 std::to_string(weights.size()));
  const float* next = weights.data();
  for (at::Tensor parameter : parameters) {
    parameter.copy_(torch::from_blob(const_cast<float*>(next), parameter.sizes(), torch::kFloat));
    next += parameter.numel();
  }
}

std::string TrainingStateOf(const torch::nn::Module& module, const torch::optim::Adam& adam) {
  torch::serialize::OutputArchive archive, weights, state;
  module.save(weights);
  adam.save(state);
  archive.write("weights", weights);
  archive.write("adam", state);
  std::ostringstream stream;
  archive.save_to(stream);
  return stream.str();
}

void RestoreTrainingStateOf(const std::string& bytes, const torch::Device& device,
                            torch::nn::Module& module, torch::optim::Adam& adam) try {
  torch::serialize::InputArchive archive, weights, state;
  archive.load_from(bytes.data(), bytes.size(), device);
  archive.read("weights", weights);
  archive.read("adam", state);
  module.load(weights);
  adam.load(state);
} catch (const c10::Error&) {
  throw InputError("the training state is damaged or of another network");
}

void SetLearningRate(torch::optim::Adam& adam, double learning_rate) {
  for (torch::optim::OptimizerParamGroup& group : adam.param_groups()) {
    static_cast<torch::optim::AdamOptions&>(group.options()).lr(learning_rate);
  }
}

at::Tensor TensorOf(const std::vector<float>& values) {
  return torch::tensor(at::ArrayRef<float>(values), torch::kFloat);
}

}  // namespace pickbed::perception
