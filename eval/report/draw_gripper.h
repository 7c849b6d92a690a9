#pragma once

// A gripper as data, drawn: its boxes from the front and from the side, with frame G and sizes.

#include <string>

#include "grasp/gripper.h"
#include "scenes/image.h"

namespace pickbed {

// Two views to one scale, the approach downwards; lengths in mm.
Image<Rgb8> GripperSheet(const GripperSpec& gripper);

// All its numbers, one a line, with what they mean.
std::string GripperText(GripperSpec gripper);

}  // namespace pickbed
