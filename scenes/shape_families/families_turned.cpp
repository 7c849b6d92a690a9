#include <array>
#include <cmath>
#include <numbers>

#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

constexpr double kBeyond_mm = 2;  // a bore extends beyond the surface by this much

constexpr std::array<ShapeParameter, 7> kFlange{{{"radius", 26, 50},
                                                 {"thickness", 5, 12},
                                                 {"hub_share", 0.4, 0.6},
                                                 {"hub_height", 6, 40},
                                                 {"bore_share", 0.5, 0.75},
                                                 {"bolts", 4, 8, true},
                                                 {"bolt_radius", 2.5, 5}}};
FamilySolid MakeFlange(ParameterValues v) {
  const double radius = v[0], disc = v[1], hub = radius * v[2], height = disc + v[3];
  const double bore = hub * v[4], bolt_circle = 0.5 * (radius + hub);
  const double bolt = std::min(v[6], 0.25 * (radius - hub));
  const Solid body = Union(Moved(Cylinder(radius, disc), {0, 0, 0.5 * disc}),
                           Moved(Cylinder(hub, height), {0, 0, 0.5 * height}));
  const Solid holes =
      Copies(Moved(Cylinder(bolt, 3 * disc), {bolt_circle, 0, 0}), static_cast<int>(v[5]));
  const double wall = std::min({disc, hub - bore, 0.5 * (radius - hub) - bolt});
  return {Cut(Cut(body, Cylinder(bore, 3 * height)), holes), wall};
}

constexpr std::array<ShapeParameter, 3> kRing{
    {{"radius", 16, 50}, {"section_share", 0.15, 0.35}, {"height", 5, 30}}};
FamilySolid MakeRing(ParameterValues v) {
  const double section = v[0] * v[1], height = std::max(v[2], 2.0);
  const double rounding = 0.15 * std::min(section, height);
  return {Cut(Cylinder(v[0], height, rounding), Cylinder(v[0] - section, height + kBeyond_mm)),
          std::min(section, height)};
}

constexpr std::array<ShapeParameter, 2> kORing{{{"radius", 14, 45}, {"section_share", 0.16, 0.4}}};
FamilySolid MakeORing(ParameterValues v) { return {Torus(v[0], v[0] * v[1]), v[0] * v[1]}; }

// The corners of the hexagon are turned off at both ends.
Solid ChamferedHexagon(double across, double height, bool at_both_ends) {
  const double corner = 0.5 * across / std::cos(std::numbers::pi / 6), flat = 0.48 * across;
  const double h = 0.5 * height, slope = 0.6 * (corner - flat);
  const double low = at_both_ends ? flat : corner;
  return Intersect(RegularPrism(6, across, height),
                   Revolved({{0, -h},
                             {low, -h},
                             {corner, at_both_ends ? slope - h : -h},
                             {corner, h - slope},
                             {flat, h},
                             {0, h}}));
}

constexpr std::array<ShapeParameter, 3> kNut{
    {{"across", 18, 48}, {"height_share", 0.45, 0.9}, {"bore_share", 0.48, 0.64}}};
FamilySolid MakeNut(ParameterValues v) {
  const double height = v[0] * v[1], bore = 0.5 * v[0] * v[2];
  return {Cut(ChamferedHexagon(v[0], height, true), Cylinder(bore, height + kBeyond_mm)),
          0.5 * v[0] - bore};
}

constexpr std::array<ShapeParameter, 4> kBolt{{{"diameter", 7, 18},
                                               {"length", 30, 120},
                                               {"head_ratio", 1.5, 1.9},
                                               {"head_height_share", 0.5, 0.8}}};
FamilySolid MakeBolt(ParameterValues v) {
  const double diameter = v[0], head = diameter * v[3], chamfer = 0.1 * diameter;
  const double radius = 0.5 * diameter, length = v[1];
  const Solid shank = Revolved(
      {{0, 0}, {radius, 0}, {radius, chamfer - length}, {radius - chamfer, -length}, {0, -length}});
  return {Union(Moved(ChamferedHexagon(diameter * v[2], head, false), {0, 0, 0.5 * head}), shank),
          std::min(radius, head)};
}

constexpr std::array<ShapeParameter, 5> kSpacer{{{"radius", 10, 24},
                                                 {"height", 15, 70},
                                                 {"bore_share", 0.4, 0.66},
                                                 {"collar", 3, 12},
                                                 {"collar_height_share", 0.15, 0.35}}};
FamilySolid MakeSpacer(ParameterValues v) {
  const double radius = v[0], height = std::max(v[1], 6.0), bore = radius * v[2];
  const double collar = std::max(height * v[4], kMinWall_mm);
  const Solid body = Union(Cylinder(radius, height),
                           Moved(Cylinder(radius + v[3], collar), {0, 0, 0.5 * (collar - height)}));
  return {Cut(body, Cylinder(bore, height + kBeyond_mm)), std::min(radius - bore, collar)};
}

constexpr std::array<ShapeParameter, 5> kGear{{{"teeth", 12, 24, true},
                                               {"radius", 20, 45},
                                               {"tooth_share", 0.12, 0.2},
                                               {"thickness", 7, 25},
                                               {"bore_share", 0.2, 0.45}}};
FamilySolid MakeGear(ParameterValues v) {
  const double tip = v[1], root = tip * (1 - v[2]), bore = root * v[4];
  const int teeth = static_cast<int>(v[0]);
  return {Cut(Gear(teeth, root, tip, v[3]), Cylinder(bore, v[3] + kBeyond_mm)),
          2 * tip * std::sin(0.3 * std::numbers::pi / teeth)};
}

constexpr std::array<ShapeParameter, 5> kShaft{{{"radius", 6, 14},
                                                {"length", 70, 190},
                                                {"step_ratio", 1.3, 2.2},
                                                {"step_share", 0.15, 0.4},
                                                {"end_share", 0.6, 0.85}}};
FamilySolid MakeShaft(ParameterValues v) {
  const double r = v[0], h = 0.5 * v[1], step = r * v[2], from = -0.2 * h;
  const double to = from + v[3] * v[1], end = r * v[4];
  return {Revolved({{0, -h},
                    {0.8 * r, -h},
                    {r, 0.2 * r - h},
                    {r, from},
                    {step, from},
                    {step, to},
                    {end, to},
                    {end, h},
                    {0, h}}),
          end};
}

constexpr std::array<ShapeParameter, 4> kPulley{
    {{"radius", 20, 45}, {"width", 12, 30}, {"groove_share", 0.15, 0.3}, {"bore_share", 0.2, 0.4}}};
FamilySolid MakePulley(ParameterValues v) {
  const double r = v[0], h = 0.5 * v[1], floor = r * (1 - v[2]), bore = floor * v[3];
  return {Revolved({{bore, -h},
                    {r, -h},
                    {r, -0.7 * h},
                    {floor, -0.15 * h},
                    {floor, 0.15 * h},
                    {r, 0.7 * h},
                    {r, h},
                    {bore, h}}),
          0.3 * h};
}

constexpr auto kTurned = ShapeDomain::kMachine;
constexpr std::array kTurnedRows{
    ShapeFamilyRow{"flange", "disc with hub, bore and bolt holes", kTurned, false, true, kFlange,
                   MakeFlange, 7850},
    ShapeFamilyRow{"ring", "ring with a rectangular section", kTurned, false, true, kRing, MakeRing,
                   7850},
    ShapeFamilyRow{"o_ring", "ring with a round section", kTurned, false, true, kORing, MakeORing,
                   1300},
    ShapeFamilyRow{"nut", "hexagon nut", kTurned, false, true, kNut, MakeNut, 7850},
    ShapeFamilyRow{"bolt", "hexagon bolt without threads", kTurned, false, false, kBolt, MakeBolt,
                   7850},
    ShapeFamilyRow{"spacer", "bush with a collar", kTurned, false, true, kSpacer, MakeSpacer, 7850},
    ShapeFamilyRow{"gear", "spur gear with a bore", kTurned, true, true, kGear, MakeGear, 7850},
    ShapeFamilyRow{"shaft", "shaft with steps", kTurned, false, false, kShaft, MakeShaft, 7850},
    ShapeFamilyRow{"pulley", "wheel with a belt groove and a bore", kTurned, false, true, kPulley,
                   MakePulley, 2700},
};

}  // namespace

std::span<const ShapeFamilyRow> TurnedFamilies() { return kTurnedRows; }

}  // namespace pickbed::scenes
