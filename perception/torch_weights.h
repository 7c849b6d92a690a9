#pragma once

// The weights of a network as plain values, and weights with the state of Adam as the bytes of a
// checkpoint: what every network here needs. Weights stand one parameter after the other, in the
// module's order.

#include <torch/nn/module.h>
#include <torch/optim/adam.h>

#include <span>
#include <string>
#include <vector>

namespace pickbed {

std::vector<float> WeightsOf(const torch::nn::Module& module);
// Throws InputError when the number does not fit the module.
void SetWeightsOf(torch::nn::Module& module, std::span<const float> weights);

std::string TrainingStateOf(const torch::nn::Module& module, const torch::optim::Adam& adam);
// Throws InputError for foreign bytes.
void RestoreTrainingStateOf(const std::string& bytes, const torch::Device& device,
                            torch::nn::Module& module, torch::optim::Adam& adam);

void SetLearningRate(torch::optim::Adam& adam, double learning_rate);

}  // namespace pickbed
