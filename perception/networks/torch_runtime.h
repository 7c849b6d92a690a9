#pragma once

// Device selection and helpers that all networks share. Networks run on CUDA if libtorch supports
// it and there is a device, otherwise on the CPU. Debian's libtorch has no CUDA. Training with the
// same seed gives the same weights only on the CPU, because the summation order of CUDA varies.

#include <torch/nn/module.h>
#include <torch/optim/adam.h>
#include <torch/types.h>

#include <span>
#include <string>
#include <vector>

#include "perception/layer.h"

namespace pickbed::perception {

// Returns the device, constant within a process. The environment variable PICKBED_DEVICE selects
// it: empty or auto, cpu, cuda. Throws InputError for other values, and for cuda without a device.
torch::Device NetworkDevice();

// Returns the weights as plain values, one parameter after the other in the module's order.
std::vector<float> WeightsOf(const torch::nn::Module& module);
// Sets the weights. Throws InputError if the number of values does not fit the module.
void SetWeightsOf(torch::nn::Module& module, std::span<const float> weights);

// Returns weights and Adam state as the bytes of a checkpoint.
std::string TrainingStateOf(const torch::nn::Module& module, const torch::optim::Adam& adam);
// Restores weights and Adam state, but not the learning rate. Throws InputError for damaged bytes
// and if they belong to another network.
void RestoreTrainingStateOf(const std::string& bytes, torch::nn::Module& module,
                            torch::optim::Adam& adam);

// Sets the learning rate of all parameter groups.
void SetLearningRate(torch::optim::Adam& adam, double learning_rate);

}  // namespace pickbed::perception
