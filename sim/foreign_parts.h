#pragma once

// Shapes that nobody has a mesh of, for piles in which not everything is a part that is looked for:
// they occlude like parts, and a candidate that sits on one of them is wrong.

#include <cstdint>

#include "scenes/object_model.h"

namespace pickbed {

struct ForeignPartOptions {
  int per_object = 4;           // shapes made for each object, of its size
  int corners_min = 4;          // points whose hull a shape is
  int corners_max = 24;         //
  double diameter_min = 0.35;   // of a shape, over the object's
  double diameter_max = 1.1;    //
  double flattest = 0.2;        // least share of a shape's length that its other sides have
  double density_kgpm3 = 1100;  // as hard plastic
  uint64_t seed = 0;
  // Throws std::logic_error.
  void Validate() const;
};

// Convex hulls of random points: per_object for each of `objects`, in their order. Each depends on
// the object's diameter and its own number alone.
ObjectSet MakeForeignParts(const ObjectSet& objects, const ForeignPartOptions& options = {});

}  // namespace pickbed
