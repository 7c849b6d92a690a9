#pragma once

// A settled scene as text, for people and other programs.

#include <string>

#include "scenes/scene.h"
#include "sim/scene_maker.h"

namespace pickbed {

// {"bin": {...}, "objects": [{"instance", "name", "position_m", "quaternion_wxyz"}]}, in W.
std::string SceneJson(const Scene& scene, const ObjectSet& objects);

// How the scene came to rest, and which were refused before it.
std::string CertificateJson(const CertifiedScene& made);
std::string CertificateText(const CertifiedScene& made);  // for people

}  // namespace pickbed
