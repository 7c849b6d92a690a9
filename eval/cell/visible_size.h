#pragma once

// Size of the objects of a scenario in its image.

#include <string>

#include "eval/layer.h"
#include "scenes/objects/object_model.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Diameter in the image below which no estimator finds an object, px.
inline constexpr double kMinVisibleDiameter_px = 20;

// Returns the depth along camera z of the objects, at a quarter of the bin height.
double WorkingDistance_m(const Camera& camera, double bin_height_m);

// Returns the first object to be picked that is smaller than kMinVisibleDiameter_px in the image,
// with the place of the camera's setting and the distance that would do. Empty if there is none.
// - objects: of the scenario, one for each entry of spec.objects
std::string TooSmallText(const ScenarioSpec& spec, const ObjectSet& objects);

}  // namespace pickbed::eval
