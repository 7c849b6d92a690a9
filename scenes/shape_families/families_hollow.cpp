#include <array>

#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

constexpr std::array<ShapeParameter, 4> kCup{
    {{"radius", 25, 45}, {"height", 50, 120}, {"wall", 2, 4}, {"taper", 0.7, 1}}};
FamilySolid MakeCup(ParameterValues v) {
  const double radius = v[0], height = v[1], wall = v[2], foot = v[0] * v[3];
  const Solid outside = Frustum(foot, radius, height);
  const Solid inside = Frustum(foot - wall, radius - wall, height);
  return {Cut(outside, Moved(inside, {0, 0, 1.5 * wall})), wall};
}

constexpr std::array<ShapeParameter, 3> kTube{
    {{"radius", 10, 35}, {"length", 40, 200}, {"wall_share", 0.1, 0.3}}};
FamilySolid MakeTube(ParameterValues v) {
  const double wall = v[0] * v[2];
  return {Cut(Cylinder(v[0], v[1]), Cylinder(v[0] - wall, v[1] + 2)), wall};
}

constexpr std::array<ShapeParameter, 3> kCarton{
    {{"width", 30, 100}, {"depth", 20, 80}, {"height", 40, 180}}};
FamilySolid MakeCarton(ParameterValues v) { return {Box({v[0], v[1], v[2]}), 20}; }

constexpr std::array kHollowRows{
    ShapeFamilyRow{"tube", "straight tube with open ends", ShapeDomain::kMachine, false, true,
                   kTube, MakeTube, 2700},
    ShapeFamilyRow{"cup", "tapered cup without a handle", ShapeDomain::kSupermarket, false, true,
                   kCup, MakeCup, 1200},
    ShapeFamilyRow{"carton", "rectangular carton", ShapeDomain::kSupermarket, false, false, kCarton,
                   MakeCarton, 400},
};

}  // namespace

std::span<const ShapeFamilyRow> HollowFamilies() { return kHollowRows; }

}  // namespace pickbed::scenes
