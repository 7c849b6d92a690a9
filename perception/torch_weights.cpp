#include "perception/torch_weights.h"

#include <torch/serialize.h>

#include <sstream>

#include "scenes/check.h"

namespace pickbed {

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

}  // namespace pickbed
