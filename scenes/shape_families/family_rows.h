#pragma once

// The rows behind ShapeFamilyTable(), by kind of shape. Each maker starts with its parameters.

#include "scenes/shape_families/shape_family.h"

namespace pickbed::scenes {

// Values of the parameters of a family, in their order.
using ParameterValues = std::span<const double>;

std::span<const ShapeFamilyRow> HollowFamilies();  // families_hollow.cpp: open vessels and pipes

}  // namespace pickbed::scenes
