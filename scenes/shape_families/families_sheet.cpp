#include <array>
#include <cmath>
#include <numbers>

#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector3d;

constexpr std::array<ShapeParameter, 5> kBracket{{{"width", 25, 70},
                                                  {"leg_x", 30, 85},
                                                  {"leg_z", 30, 85},
                                                  {"wall", 3, 8},
                                                  {"hole_share", 0.15, 0.4}}};
// An angle in xz, extruded along y, with a hole in each leg and a rib between them.
FamilySolid MakeBracket(ParameterValues v) {
  const double width = v[0], x = v[1], z = v[2], wall = LimitedWall(v[3], 0.25 * std::min(x, z));
  const double hole = 0.5 * v[4] * std::min({width, x - 2 * wall, z - 2 * wall});
  const Solid legs = Union(Moved(Box({x, width, wall}), {0.5 * x, 0, 0.5 * wall}),
                           Moved(Box({wall, width, z}), {0.5 * wall, 0, 0.5 * z}));
  const double rib = 0.45 * std::min(x, z);
  const Solid gusset =
      Turned(Extruded({{wall, wall}, {wall + rib, wall}, {wall, wall + rib}}, wall),
             Vector3d::UnitX(), 90);
  const Solid side = Moved(gusset, {0, 0.5 * (wall - width), 0});
  const Solid holes = Union(Moved(Cylinder(hole, 4 * wall), {0.5 * (x + wall), 0, 0}),
                            Moved(CylinderAlongX(hole, 4 * wall), {0, 0, 0.5 * (z + wall)}));
  return {Union(Cut(legs, holes), side), wall};
}

constexpr std::array<ShapeParameter, 5> kZBracket{
    {{"low", 20, 55}, {"high", 20, 55}, {"height", 25, 70}, {"width", 20, 60}, {"wall", 3, 7}}};
FamilySolid MakeZBracket(ParameterValues v) {
  const double height = v[2], wall = LimitedWall(v[4], 0.25 * height);
  return {Extruded({{-v[0], 0},
                    {wall, 0},
                    {wall, height - wall},
                    {v[1] + wall, height - wall},
                    {v[1] + wall, height},
                    {0, height},
                    {0, wall},
                    {-v[0], wall}},
                   v[3]),
          wall};
}

constexpr std::array<ShapeParameter, 6> kBearingBlock{{{"bore", 8, 20},
                                                       {"wall", 5, 12},
                                                       {"width", 15, 45},
                                                       {"foot", 12, 30},
                                                       {"base", 6, 14},
                                                       {"rise", 2, 20}}};
FamilySolid MakeBearingBlock(ParameterValues v) {
  const double bore = v[0], outer = bore + v[1], width = v[2], base = v[4];
  const double center = base + outer + std::max(v[5], 0.0), length = 2 * (outer + v[3]);
  const Solid body = Union({Moved(Box({length, width, base}), {0, 0, 0.5 * base}),
                            Moved(Box({2 * outer, width, center}), {0, 0, 0.5 * center}),
                            Moved(CylinderAlongY(outer, width), {0, 0, center})});
  const double bolt = std::min(0.25 * v[3], 0.3 * width);
  const Solid bolts =
      Mirrored(Moved(Cylinder(bolt, 3 * base), {outer + 0.55 * v[3], 0, 0}), true, false, false);
  return {Cut(Cut(body, Moved(CylinderAlongY(bore, width + 2), {0, 0, center})), bolts),
          std::min({v[1], base, 0.45 * v[3] - bolt})};
}

constexpr std::array<ShapeParameter, 6> kRod{{{"length", 60, 150},
                                              {"eye", 11, 24},
                                              {"small_share", 0.6, 0.9},
                                              {"bore_share", 0.4, 0.64},
                                              {"thickness", 6, 16},
                                              {"shank_share", 0.4, 0.7}}};
FamilySolid MakeRod(ParameterValues v) {
  const double length = v[0], big = v[1], small = big * v[2], thickness = v[4];
  const double half = 0.5 * length;
  const auto at_ends = [&](double a, double b, double height) {
    return Union(Moved(Cylinder(a, height), {-half, 0, 0}),
                 Moved(Cylinder(b, height), {half, 0, 0}));
  };
  const Solid shank = Box({length, 2 * small * v[5], 0.7 * thickness});
  const Solid body = Union(at_ends(big, small, thickness), shank);
  return {Cut(body, at_ends(big * v[3], small * v[3], 2 * thickness)),
          std::min(small * (1 - v[3]), 0.7 * thickness)};
}

constexpr std::array<ShapeParameter, 5> kUClip{
    {{"radius", 8, 24}, {"leg", 25, 75}, {"wall", 2, 4}, {"width", 10, 40}, {"hook", 4, 12}}};
// A bent strip: half a ring, two legs along -x and hooks that point outwards.
FamilySolid MakeUClip(ParameterValues v) {
  const double inner = std::max(v[0], 3.0), wall = LimitedWall(v[2], inner), width = v[3];
  const double center = inner + 0.5 * wall;
  const Solid bow = Intersect(Cut(Cylinder(inner + wall, width), Cylinder(inner, width + 2)),
                              HalfSpace({-1, 0, 0}, 0));
  const Solid leg = Moved(Box({v[1], wall, width}), {-0.5 * v[1], center, 0});
  const double hook = std::max(v[4], wall);
  const Solid end = Moved(Box({wall, hook, width}), {0.5 * wall - v[1], inner + 0.5 * hook, 0});
  return {Union(bow, Mirrored(Union(leg, end), false, true, false)), wall};
}

constexpr std::array<ShapeParameter, 5> kHoseClamp{
    {{"radius", 12, 35}, {"wall", 2, 4}, {"width", 9, 25}, {"lug", 9, 20}, {"gap", 3, 9}}};
// A ring that is open at x > 0, with two lugs that a screw would pull together.
FamilySolid MakeHoseClamp(ParameterValues v) {
  const double radius = v[0], wall = LimitedWall(v[1], 0.5 * radius), width = v[2];
  const double lug_wall = 1.2 * wall, gap = std::max(v[4], 1.0);
  const Solid ring = Cut(Cylinder(radius + wall, width), Cylinder(radius, width + 2));
  const Solid opening = Moved(Box({2 * radius, gap, width + 2}), {radius + wall, 0, 0});
  const double x = radius + 0.5 * v[3];
  const Solid lug = Moved(Box({v[3], lug_wall, width}), {x, 0.5 * (gap + lug_wall), 0});
  const Solid hole = Moved(CylinderAlongY(std::min(0.2 * v[3], 0.25 * width), 4 * (gap + wall)),
                           {x + 0.15 * v[3], 0, 0});
  return {Cut(Union(Cut(ring, opening), Mirrored(lug, false, true, false)), hole), wall};
}

constexpr std::array<ShapeParameter, 5> kHolePlate{{{"length", 50, 150},
                                                    {"width", 30, 75},
                                                    {"thickness", 3, 10},
                                                    {"hole", 3, 7},
                                                    {"window_share", 0.2, 0.5}}};
FamilySolid MakeHolePlate(ParameterValues v) {
  const double length = v[0], width = v[1], thickness = LimitedWall(v[2], 100);
  const double margin = 0.18 * width, hole = std::min(v[3], 0.55 * margin);
  const Solid holes = Mirrored(
      Moved(Cylinder(hole, 3 * thickness), {0.5 * length - margin, 0.5 * width - margin, 0}), true,
      true, false);
  const Solid window =
      Extruded(RoundedRectangle((length - 3 * margin) * v[4], width * v[4], 0.1 * width * v[4]),
               3 * thickness);
  return {
      Cut(Cut(Extruded(RoundedRectangle(length, width, 0.8 * margin), thickness), holes), window),
      std::min(thickness, margin - hole)};
}

constexpr auto kSheet = ShapeDomain::kMachine;
constexpr std::array kSheetRows{
    ShapeFamilyRow{"bracket", "angle with two holes and a rib at one side", kSheet, false, false,
                   kBracket, MakeBracket, 2700},
    ShapeFamilyRow{"z_bracket", "Z of bent sheet", kSheet, false, false, kZBracket, MakeZBracket,
                   2700},
    ShapeFamilyRow{"bearing_block", "block with a bore on a foot with two bolt holes", kSheet,
                   false, true, kBearingBlock, MakeBearingBlock, 2700},
    ShapeFamilyRow{"rod_with_eyes", "connecting rod with two eyes", kSheet, true, true, kRod,
                   MakeRod, 7850},
    ShapeFamilyRow{"u_clip", "U of sheet with hooks", kSheet, true, true, kUClip, MakeUClip, 2700},
    ShapeFamilyRow{"hose_clamp", "open ring with two lugs", kSheet, false, true, kHoseClamp,
                   MakeHoseClamp, 7850},
    ShapeFamilyRow{"hole_plate", "plate with four holes and a window", kSheet, false, true,
                   kHolePlate, MakeHolePlate, 2700},
};

}  // namespace

OutlineMm RoundedRectangle(double length, double width, double radius) {
  constexpr int kSteps = 5;  // of a corner
  OutlineMm outline;
  for (int corner = 0; corner < 4; ++corner) {
    const double sx = corner == 0 || corner == 3 ? 1 : -1, sy = corner < 2 ? 1 : -1;
    for (int i = 0; i <= kSteps; ++i) {
      const double angle = 0.5 * std::numbers::pi * (corner + static_cast<double>(i) / kSteps);
      outline.emplace_back(sx * (0.5 * length - radius) + radius * std::cos(angle),
                           sy * (0.5 * width - radius) + radius * std::sin(angle));
    }
  }
  return outline;
}

std::span<const ShapeFamilyRow> SheetFamilies() { return kSheetRows; }

}  // namespace pickbed::scenes
