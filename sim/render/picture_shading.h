#pragma once

// Materials of the surfaces in a picture, and the light that they reflect.

#include <Eigen/Core>

#include "scenes/image/image.h"
#include "scenes/objects/object_model.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Reflection of a surface in a picture.
enum class Finish { kMatte, kPlastic, kMetal };

// Material of one instance in a picture.
struct PictureMaterial {
  Finish finish = Finish::kPlastic;
  // Linear red, green and blue in 0..1. Negative: the color of the mesh.
  Eigen::Vector3f color{-1, -1, -1};
};

// Returns the finish and color of an object. The finish follows its density: cardboard, plastic,
// metal. The color is the color of its mesh; if the mesh has none, it follows density and name. A
// texture and vertex colors are kept.
PictureMaterial PictureMaterialOf(const ObjectModel& object);

// Surface at one sample of a picture.
struct PictureSurface {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal_W = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f to_camera_W = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f to_key_W = Eigen::Vector3f::UnitZ();
  float direct = 0;     // light of the lamp that arrives, times the cosine
  float occlusion = 1;  // share of the surroundings that is visible
  Finish finish = Finish::kMatte;
};

// Returns the linear light that a surface reflects to the camera: diffuse light of the lamp and the
// surroundings, a reflection of both, and the highlight of the lamp (Blinn, "Models of Light
// Reflection for Computer Synthesized Pictures", SIGGRAPH 1977) with the Fresnel term of Schlick
// ("An Inexpensive BRDF Model for Physically-based Rendering", 1994).
Eigen::Vector3f Shade(const PictureSurface& s);

// Converts a color to linear light.
Eigen::Vector3f LinearOf(const Rgb8& c);
// Converts linear light to the value of a pixel, with a soft limit for bright light.
uint8_t Displayed(float linear);

}  // namespace pickbed::sim
