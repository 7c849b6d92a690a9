#pragma once

// Drawing of a gripper from its data: its boxes from the front and from the side, with frame G and
// dimensions.

#include <string>

#include "eval/layer.h"
#include "grasp/gripper.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Draws two views at the same scale, approach direction downwards; dimensions in mm.
Image<Rgb8> GripperSheet(const Gripper& gripper);

// All settings of the gripper with their help texts, one per line.
std::string GripperText(const Gripper& gripper);

}  // namespace pickbed::eval
