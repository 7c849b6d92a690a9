#pragma once

// Names of sampled shapes, which a scenario can use like the names of objects:
//
//   sampled/WHAT/SEED
//   sampled/WHAT/SPLIT/SEED
//
// WHAT is a shape family or a domain. SPLIT is seen (default), unseen_sizes or outside; a domain
// also has unseen_families. A domain draws the family from its training families, or from its
// held-out ones for unseen_families. The same name always gives the same shape.
//
// A scenario may give a range FIRST-LAST of seeds, which gives a shape of each seed.

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"
#include "scenes/shape_families/shape_family.h"

namespace pickbed::scenes {

// Returns whether the name begins with "sampled/".
bool IsSampledName(const std::string& name);

// Samples the shape of a name. Throws InputError for a malformed name, family, split or seed.
SampledShape SampleShapeByName(const std::string& name);

// Returns the names of all shapes of a name with a range of seeds; else only the name itself.
// Throws InputError for a malformed range and for more than kMaxSampledShapes.
std::vector<std::string> SampledNamesIn(const std::string& name);
inline constexpr int kMaxSampledShapes = 1000;

// Samples a shape of `what`, a family or a domain, with the split of a name.
SampledShape SampleShapeOf(const std::string& what, const std::string& split, uint64_t seed);

// Returns a plausible color of the shape's domain. It depends only on the family and the seed.
Rgb8 SampledColor(const SampledShape& shape);

// Friction coefficient of all sampled shapes against a gripper pad.
inline constexpr double kSampledFriction = 0.5;

}  // namespace pickbed::scenes
