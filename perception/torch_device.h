#pragma once

// Where networks run: the one place that chooses. On CUDA where libtorch has it and there is a
// device, else on the CPU; Debian's libtorch has no CUDA. PICKBED_DEVICE=cpu keeps to the CPU. The
// same seed gives the same weights on the CPU alone: CUDA adds in an order of its own.

#include <torch/types.h>

namespace pickbed {

// The same each time in one process. Throws InputError when PICKBED_DEVICE is neither empty, auto,
// cpu nor cuda, or asks for CUDA where there is none.
torch::Device NetworkDevice();

}  // namespace pickbed
