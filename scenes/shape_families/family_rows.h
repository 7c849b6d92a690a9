#pragma once

// The rows behind ShapeFamilyTable(), by kind of shape, and shapes that several of them use.

#include <algorithm>

#include "scenes/shape_families/shape_family.h"

namespace pickbed::scenes {

// Values of the parameters of a family, in their order.
using ParameterValues = std::span<const double>;

// Makers limit walls to this thickness, because outside sizes may be thinner. mm
inline constexpr double kMinWall_mm = 1.5;
// Returns the wall, at least kMinWall_mm and else at most `limit`.
inline double LimitedWall(double wall, double limit) {
  return std::max(kMinWall_mm, std::min(wall, limit));
}

// An open vessel: the outline (distance from z, z; from the bottom to the rim, mm) revolved about
// z, hollow with this wall. The bottom starts at z = outline.front().y().
Solid OpenVessel(OutlineMm outline, double wall);
// A corner-rounded rectangle in xy.
OutlineMm RoundedRectangle(double length, double width, double radius);
// A cylinder along y.
Solid CylinderAlongY(double radius, double length);
// A cylinder along x.
Solid CylinderAlongX(double radius, double length);

std::span<const ShapeFamilyRow> PipeFamilies();     // families_pipes.cpp: pipes and profiles
std::span<const ShapeFamilyRow> TurnedFamilies();   // families_turned.cpp: lathe parts and gears
std::span<const ShapeFamilyRow> SheetFamilies();    // families_sheet.cpp: sheet and cast parts
std::span<const ShapeFamilyRow> VesselFamilies();   // families_vessels.cpp: open vessels
std::span<const ShapeFamilyRow> PackageFamilies();  // families_packages.cpp: packaged goods
std::span<const ShapeFamilyRow> FreeFamilies();     // families_free.cpp: shapes without a purpose

}  // namespace pickbed::scenes
