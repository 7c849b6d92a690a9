#pragma once

// A settled scene as text, for the console and for other programs.

#include <string>

#include "eval/layer.h"
#include "scenes/scene.h"
#include "sim/drop/certified_scene.h"

namespace pickbed::eval {

// Returns {"bin": {...}, "objects": [{"instance", "name", "position_m", "quaternion_wxyz"}]}; poses
// are X_WO.
std::string SceneJson(const Scene& scene, const ObjectSet& objects);

// Return the certificate of the scene and the refused scenes before it, as JSON and as console
// text.
std::string CertificateJson(const CertifiedScene& made);
std::string CertificateText(const CertifiedScene& made);

}  // namespace pickbed::eval
