#pragma once

// Full layers with the same result on every x86-64 CPU. OpenBLAS, which libtorch uses for them,
// selects a kernel for the CPU that it finds, and each kernel sums in another order.

#include <torch/nn/modules/linear.h>
#include <torch/types.h>

#include "perception/layer.h"

namespace pickbed::perception {

// Applies a layer to rows of shape [count, inputs]. While gradients are recorded or on another
// device than the CPU, libtorch computes it: training need not give the same bits everywhere.
at::Tensor ApplyLinear(torch::nn::Linear& layer, const at::Tensor& rows);

}  // namespace pickbed::perception
