#pragma once

// Shape families: distributions of solids over parameters with ranges, for two domains.
//
// Every family has splits, so that a learned method can be tested on what it was not trained on:
//
//   low               range of a parameter                 high
//    |=======|xxxx|========|xxxx|========|xxxx|=======|
//   ..          seen (=)      unseen sizes (x)         ..   outside: beyond one of the ends
//
// A seen shape has all parameters in seen intervals; a shape of unseen sizes has all in held-out
// intervals; an outside shape has at least one parameter beyond an end. Families with `held_out`
// are unseen as a whole.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/shape_families/solid_builder.h"
#include "scenes/shape_families/solid_shape.h"

namespace pickbed::scenes {

enum class ShapeDomain { kMachine, kSupermarket };
enum class ShapeSplit { kSeen, kUnseenSizes, kOutside };

// A parameter and its range. Lengths are in mm. Angles are in degrees and end in "_deg". A whole
// number is a count.
struct ShapeParameter {
  const char* name;
  double low;
  double high;
  bool whole = false;
};

// A solid of a family, and its thinnest wall or the radius of its thinnest rod.
struct FamilySolid {
  Solid solid;
  double min_wall_mm;
};

// A row of the table.
struct ShapeFamilyRow {
  const char* name;
  const char* help;
  ShapeDomain domain;
  bool held_out;  // unseen in training as a whole family
  bool hollow;    // has a cavity or a bore whose center is outside the solid
  std::span<const ShapeParameter> parameters;
  // Makes the solid from one value for each parameter, in the order of `parameters`.
  FamilySolid (*make)(std::span<const double> values);
  double density_kgpm3;  // of the material, or of the filled package
};

// Returns all families: machine first, then supermarket.
std::span<const ShapeFamilyRow> ShapeFamilyTable();

// Returns the row. Throws InputError for an unknown name, with the nearest known name.
const ShapeFamilyRow& FindShapeFamily(const std::string& name);

// Returns the names "machine" | "supermarket" and "seen" | "unseen_sizes" | "outside", and the
// values of such names. The latter throw InputError for another name.
std::string ShapeDomainName(ShapeDomain domain);
std::string ShapeSplitName(ShapeSplit split);
ShapeDomain ShapeDomainFromName(const std::string& name);
ShapeSplit ShapeSplitFromName(const std::string& name);

// Returns the families of a domain that are held out, or the other ones.
std::vector<const ShapeFamilyRow*> ShapeFamiliesOf(ShapeDomain domain, bool held_out);

// A solid that was drawn from a family.
struct SampledShape {
  const ShapeFamilyRow* family = nullptr;
  ShapeSplit split = ShapeSplit::kSeen;
  uint64_t seed = 0;
  std::vector<double> values;  // in the order of family->parameters
  SolidShape solid;
};

// Draws the parameters and makes the solid. The result depends only on the arguments.
SampledShape SampleShape(const ShapeFamilyRow& family, ShapeSplit split, uint64_t seed);

}  // namespace pickbed::scenes
