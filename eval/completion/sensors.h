#pragma once

// Depth sensors of the simulation for the views of shape completion.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "perception/completion/random_view.h"

namespace pickbed::eval {

// Returns the sensors with these profiles (names or files, see LoadSensorProfile()). Their range is
// not limited, because the distances of the views are. Throws InputError for an unknown profile.
std::vector<DepthSensor> DepthSensorsNamed(const std::vector<std::string>& names);

}  // namespace pickbed::eval
