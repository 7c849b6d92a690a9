#include <array>

#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

constexpr std::array<ShapeParameter, 4> kCup{
    {{"radius", 26, 45}, {"height", 50, 120}, {"wall", 2, 4}, {"taper", 0.65, 1}}};
FamilySolid MakeCup(ParameterValues v) {
  const double wall = LimitedWall(v[2], 10), foot = v[0] * std::min(v[3], 1.05);
  return {OpenVessel({{foot, 0}, {v[0], v[1]}}, wall), wall};
}

constexpr std::array<ShapeParameter, 5> kMug{{{"radius", 28, 43},
                                              {"height", 65, 115},
                                              {"wall", 2.5, 4.5},
                                              {"handle_share", 0.25, 0.36},
                                              {"handle_radius", 4, 7}}};
FamilySolid MakeMug(ParameterValues v) {
  const double radius = v[0], height = v[1], wall = LimitedWall(v[2], 10);
  const double grip = std::max(v[4], 2.0), bow = std::min(v[3] * height, 0.48 * height - grip);
  const Solid handle = Moved(Turned(Bend(bow, grip, 200), Eigen::Vector3d::UnitX(), 90),
                             {radius - 1, 0, 0.5 * height});
  const Solid outside = Moved(Cylinder(radius, height), {0, 0, 0.5 * height});
  const Solid inside = Moved(Cylinder(radius - wall, height), {0, 0, 0.5 * height + 1.2 * wall});
  return {Cut(Union(outside, handle), inside), wall};
}

constexpr std::array<ShapeParameter, 5> kOpenJar{{{"radius", 26, 45},
                                                  {"height", 60, 130},
                                                  {"wall", 2, 4},
                                                  {"neck_share", 0.65, 0.9},
                                                  {"neck_height", 10, 24}}};
FamilySolid MakeOpenJar(ParameterValues v) {
  const double radius = v[0], height = v[1], wall = LimitedWall(v[2], 10), neck = radius * v[3];
  const double shoulder = height - v[4];
  return {OpenVessel({{radius - 3, 0},
                      {radius, 4},
                      {radius, shoulder - (radius - neck)},
                      {neck, shoulder},
                      {neck, height}},
                     wall),
          wall};
}

constexpr std::array<ShapeParameter, 4> kBowl{
    {{"radius", 42, 85}, {"depth_share", 0.4, 0.75}, {"wall", 2, 4.5}, {"foot_share", 0.3, 0.5}}};
FamilySolid MakeBowl(ParameterValues v) {
  const double radius = v[0], depth = radius * v[1], wall = LimitedWall(v[2], 10);
  const double foot = radius * v[3];
  OutlineMm outline{{foot, 0}};
  // A quarter of an ellipse from the foot to the rim.
  for (const auto& [s, c] :
       {std::pair{0.309, 0.951}, {0.588, 0.809}, {0.809, 0.588}, {0.951, 0.309}, {1.0, 0.0}}) {
    outline.emplace_back(foot + (radius - foot) * s, depth * (1 - c));
  }
  return {OpenVessel(outline, wall), wall};
}

constexpr std::array<ShapeParameter, 4> kPlate{
    {{"radius", 50, 95}, {"height", 13, 26}, {"wall", 2.5, 5}, {"foot_share", 0.5, 0.7}}};
FamilySolid MakePlate(ParameterValues v) {
  const double radius = v[0], height = v[1], foot = radius * v[3];
  const double wall = LimitedWall(v[2], 0.4 * height);
  return {OpenVessel({{foot, 0},
                      {foot + 0.3 * (radius - foot), 0.5 * height},
                      {radius - 0.5, height - 1.2 * wall},
                      {radius, height}},
                     wall),
          wall};
}

constexpr std::array<ShapeParameter, 5> kTray{{{"length", 90, 190},
                                               {"width", 55, 130},
                                               {"height", 16, 45},
                                               {"wall", 1.8, 3},
                                               {"corner", 4, 14}}};
FamilySolid MakeTray(ParameterValues v) {
  const double height = v[2], wall = LimitedWall(v[3], 5);
  const Solid block = Extruded(RoundedRectangle(v[0], v[1], v[4]), 2 * height);
  return {Intersect(Shelled(block, wall), HalfSpace(Eigen::Vector3d::UnitZ(), 0)), wall};
}

constexpr auto kVessel = ShapeDomain::kSupermarket;
constexpr std::array kVesselRows{
    ShapeFamilyRow{"cup", "tapered cup without a handle", kVessel, false, true, kCup, MakeCup,
                   1200},
    ShapeFamilyRow{"mug", "mug with a handle", kVessel, true, true, kMug, MakeMug, 2300},
    ShapeFamilyRow{"open_jar", "jar without its lid", kVessel, false, true, kOpenJar, MakeOpenJar,
                   2400},
    ShapeFamilyRow{"bowl", "round bowl", kVessel, false, true, kBowl, MakeBowl, 2300},
    ShapeFamilyRow{"plate", "deep plate", kVessel, false, true, kPlate, MakePlate, 2300},
    ShapeFamilyRow{"tray", "thin-walled tray with round corners", kVessel, false, true, kTray,
                   MakeTray, 1000},
};

}  // namespace

Solid OpenVessel(OutlineMm outline, double wall) {
  const double bottom = outline.front().y(), rim = outline.back().y();
  // The closed vessel is taller by more than its wall, which the cut at the rim removes.
  outline.emplace_back(outline.back().x(), rim + 2 * wall);
  outline.emplace_back(0, rim + 2 * wall);
  outline.emplace_back(0, bottom);
  return Intersect(Shelled(Revolved(outline), wall), HalfSpace(Eigen::Vector3d::UnitZ(), rim));
}

std::span<const ShapeFamilyRow> VesselFamilies() { return kVesselRows; }

}  // namespace pickbed::scenes
