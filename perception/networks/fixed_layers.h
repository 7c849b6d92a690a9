#pragma once

// Layers of networks with the same result on every x86-64 CPU. Libraries that libtorch uses
// (OpenBLAS, oneDNN, SLEEF) select a kernel for the CPU that they find, and each kernel rounds in
// another way. While gradients are recorded or on another device than the CPU, libtorch computes
// these layers: training need not give the same bits everywhere.

#include <torch/nn/modules/linear.h>
#include <torch/types.h>

#include "perception/layer.h"

namespace pickbed::perception {

// Returns whether libtorch computes a layer with this weight for this input.
bool ComputedByLibtorch(const at::Tensor& weight, const at::Tensor& input);

// Applies a layer to values of shape [..., inputs].
at::Tensor ApplyLinear(torch::nn::Linear& layer, const at::Tensor& rows);

// Normalizes each row to unit norm.
at::Tensor UnitRows(const at::Tensor& rows);

// Returns the softmax of each row.
at::Tensor ClassProbabilities(const at::Tensor& logits);

// Apply 1 / (1 + exp(-x)) and exp(x) to each value.
at::Tensor ApplyLogistic(const at::Tensor& values);
at::Tensor ApplyExponential(const at::Tensor& values);

}  // namespace pickbed::perception
