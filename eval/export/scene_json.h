#pragma once

// A settled scene as text, for the console and for other programs.

#include <string>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "scenes/scene.h"
#include "sim/drop/certified_scene.h"

namespace pickbed::eval {

inline constexpr char kSceneFile[] = "scene.json";
inline constexpr char kCertificateFile[] = "certificate.json";

// Returns {"bin": {...}, "objects": [{"instance", "name", "position_m", "quaternion_wxyz"}]}; poses
// are X_WO.
std::string SceneJson(const Scene& scene, const ObjectSet& objects);
// Returns the keys of SceneJson().
ResultColumns SceneKeys();

// Returns the certificate of the scene and the refused scenes before it, as JSON.
std::string CertificateJson(const CertifiedScene& made);
// Returns the same certificate as console text.
std::string CertificateText(const CertifiedScene& made);
ResultColumns CertificateKeys();  // of the JSON

}  // namespace pickbed::eval
