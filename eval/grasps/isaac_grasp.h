#pragma once

// Reader of isaac_grasp YAML, format version 1.0.

#include <string>

#include "eval/grasps/grasp_file.h"

namespace pickbed::eval {

// Reads the text of a file. Errors begin with `name` and a line. Throws InputError, see
// ReadGraspFile(). Unknown keys are ignored, since programs add their own.
GraspFile ReadIsaacGrasps(const std::string& text, const std::string& name);

}  // namespace pickbed::eval
