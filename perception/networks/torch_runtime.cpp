#include "perception/networks/torch_runtime.h"

#include <torch/cuda.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <string>

#include "perception/networks/tensor_file.h"
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

namespace {

constexpr const char* kStateKind = "training state";
constexpr int kStateVersion = 1;

TensorShape ShapeOf(const at::Tensor& tensor) { return tensor.sizes().vec(); }

void Put(const std::string& name, const at::Tensor& tensor, TensorFile& file) {
  const at::Tensor values = tensor.detach().cpu().contiguous();
  const auto count = static_cast<size_t>(values.numel());
  if (values.scalar_type() == torch::kLong) {
    file.Put(name, std::span(values.data_ptr<int64_t>(), count), ShapeOf(values));
  } else {
    file.Put(name, std::span(values.data_ptr<float>(), count), ShapeOf(values));
  }
}

// Copies an entry into a tensor of the same shape.
void Copy(const TensorFile& file, const std::string& name, at::Tensor tensor) {
  CheckInput(file.Shape(name) == ShapeOf(tensor), "the training state is of another network");
  const auto copy = [&](auto values, torch::Dtype type) {
    tensor.copy_(torch::from_blob(values.data(), tensor.sizes(), type));
  };
  if (tensor.scalar_type() == torch::kLong) {
    copy(file.Integers(name), torch::kLong);
  } else {
    copy(file.Floats(name), torch::kFloat);
  }
}

// The key under which Adam keeps the state of a parameter.
std::string AdamKey(const at::Tensor& parameter) {
  return c10::guts::to_string(parameter.unsafeGetTensorImpl());
}

}  // namespace

std::string TrainingStateOf(const torch::nn::Module& module, const torch::optim::Adam& adam) {
  TensorFile file(kStateKind, kStateVersion);
  for (const auto& buffer : module.named_buffers()) {
    Put("buffer " + buffer.key(), buffer.value(), file);
  }
  for (const auto& parameter : module.named_parameters()) {
    Put("parameter " + parameter.key(), parameter.value(), file);
    const auto found = adam.state().find(AdamKey(parameter.value()));
    if (found == adam.state().end()) continue;  // before the first step
    const auto& state = static_cast<const torch::optim::AdamParamState&>(*found->second);
    const std::array<int64_t, 1> step{state.step()};
    file.Put("step " + parameter.key(), step, {});
    Put("first moment " + parameter.key(), state.exp_avg(), file);
    Put("second moment " + parameter.key(), state.exp_avg_sq(), file);
  }
  return file.Bytes();
}

void RestoreTrainingStateOf(const std::string& bytes, torch::nn::Module& module,
                            torch::optim::Adam& adam) {
  const torch::NoGradGuard no_gradients;
  const TensorFile file = TensorFile::Parse(bytes, kStateKind, kStateVersion, kStateVersion);
  for (const auto& buffer : module.named_buffers()) {
    Copy(file, "buffer " + buffer.key(), buffer.value());
  }
  for (const auto& parameter : module.named_parameters()) {
    Copy(file, "parameter " + parameter.key(), parameter.value());
    if (!file.Has("step " + parameter.key())) continue;
    auto state = std::make_unique<torch::optim::AdamParamState>();
    state->step(file.Integers("step " + parameter.key()).at(0));
    state->exp_avg(torch::zeros_like(parameter.value()));
    state->exp_avg_sq(torch::zeros_like(parameter.value()));
    Copy(file, "first moment " + parameter.key(), state->exp_avg());
    Copy(file, "second moment " + parameter.key(), state->exp_avg_sq());
    adam.state()[AdamKey(parameter.value())] = std::move(state);
  }
}

void SetLearningRate(torch::optim::Adam& adam, double learning_rate) {
  for (torch::optim::OptimizerParamGroup& group : adam.param_groups()) {
    static_cast<torch::optim::AdamOptions&>(group.options()).lr(learning_rate);
  }
}

}  // namespace pickbed::perception
