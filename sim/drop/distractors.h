#pragma once

// Random shapes without an object model, for scenes that also contain unknown objects. They occlude
// like objects, and a pose hypothesis on one of them is wrong.

#include <cstdint>

#include "scenes/objects/object_model.h"
#include "sim/layer.h"

namespace pickbed::sim {

struct DistractorOptions {
  int per_object = 4;   // shapes per object, scaled to its diameter
  int corners_min = 4;  // points of a shape's convex hull
  int corners_max = 24;
  double diameter_min = 0.35;  // shape diameter over the object's diameter
  double diameter_max = 1.1;
  double flattest = 0.2;        // smallest ratio of a shape's other extents to its length
  double density_kgpm3 = 1100;  // hard plastic
  uint64_t seed = 0;
  // Throws std::logic_error for values out of range.
  void Validate() const;
};

// Returns convex hulls of random points: `per_object` shapes for each of `objects`, in their order.
// Each shape depends only on the seed, its number and the object's diameter. Throws
// std::logic_error for invalid options.
ObjectSet MakeDistractors(const ObjectSet& objects, const DistractorOptions& options = {});

}  // namespace pickbed::sim
