#pragma once

// A settled scene as text, for people and other programs.

#include <string>

#include "scenes/scene.h"
#include "sim/drop.h"

namespace pickbed {

// {"bin": {...}, "objects": [{"instance", "name", "position_m", "quaternion_wxyz"}]}, in W.
std::string SceneJson(const Scene& scene, const ObjectSet& objects);

// How the drop went, one fact a line.
std::string DropReportText(const DropReport& report, size_t parts);

}  // namespace pickbed
