#include <array>

#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

constexpr double kThrough_mm = 2;  // a cut extends beyond the surface by this much

// A bend about z with straight legs at both ends, symmetric to x.
Solid BentRod(double circle_radius, double radius, double angle_deg, double leg) {
  const Solid straight = Moved(CylinderAlongY(radius, leg), {circle_radius, 0.5 * leg, 0});
  const Solid end = Turned(straight, Eigen::Vector3d::UnitZ(), 0.5 * angle_deg);
  return Union(Bend(circle_radius, radius, angle_deg), Mirrored(end, false, true, false));
}

constexpr std::array<ShapeParameter, 3> kTube{
    {{"radius", 12, 35}, {"length", 45, 190}, {"wall", 2, 6}}};
FamilySolid MakeTube(ParameterValues v) {
  const double radius = v[0], length = v[1], wall = LimitedWall(v[2], 0.6 * radius);
  return {Cut(Cylinder(radius, length), Cylinder(radius - wall, length + kThrough_mm)), wall};
}

constexpr std::array<ShapeParameter, 5> kPipe{{{"radius", 10, 28},
                                               {"length", 55, 180},
                                               {"wall", 2, 5},
                                               {"collar", 3, 10},
                                               {"collar_length", 6, 20}}};
FamilySolid MakePipe(ParameterValues v) {
  const double radius = v[0], length = v[1], wall = LimitedWall(v[2], 0.6 * radius);
  const Solid collar = Moved(Cylinder(radius + v[3], v[4], 1), {0, 0, 0.5 * (length - v[4])});
  const Solid outside = Union(Cylinder(radius, length), collar);
  return {Cut(outside, Cylinder(radius - wall, length + kThrough_mm)), wall};
}

constexpr std::array<ShapeParameter, 5> kPipeElbow{{{"radius", 10, 20},
                                                    {"bend_ratio", 1.4, 2.4},
                                                    {"wall", 2, 4},
                                                    {"angle_deg", 60, 120},
                                                    {"leg", 12, 50}}};
FamilySolid MakePipeElbow(ParameterValues v) {
  const double radius = v[0], wall = LimitedWall(v[2], 0.5 * radius), circle = radius * v[1];
  return {Cut(BentRod(circle, radius, v[3], v[4]),
              BentRod(circle, radius - wall, v[3], v[4] + kThrough_mm)),
          wall};
}

constexpr std::array<ShapeParameter, 4> kPipeTee{
    {{"radius", 10, 22}, {"length", 70, 140}, {"branch", 20, 60}, {"wall", 2, 4}}};
FamilySolid MakePipeTee(ParameterValues v) {
  const double radius = v[0], length = v[1], wall = LimitedWall(v[3], 0.5 * radius);
  const auto tee = [&](double r, double beyond) {
    const double up = radius + v[2] + beyond;
    return Union(CylinderAlongX(r, length + 2 * beyond), Moved(Cylinder(r, up), {0, 0, 0.5 * up}));
  };
  return {Cut(tee(radius, 0), tee(radius - wall, kThrough_mm)), wall};
}

constexpr std::array<ShapeParameter, 4> kChannel{
    {{"width", 20, 60}, {"height", 16, 50}, {"length", 45, 190}, {"wall", 2, 5}}};
FamilySolid MakeChannel(ParameterValues v) {
  const double w = 0.5 * v[0], h = v[1], wall = LimitedWall(v[3], 0.25 * std::min(v[0], h));
  return {Extruded({{-w, 0},
                    {w, 0},
                    {w, h},
                    {w - wall, h},
                    {w - wall, wall},
                    {wall - w, wall},
                    {wall - w, h},
                    {-w, h}},
                   v[2]),
          wall};
}

constexpr std::array<ShapeParameter, 4> kIProfile{
    {{"width", 20, 55}, {"height", 24, 70}, {"length", 40, 180}, {"wall", 3, 7}}};
FamilySolid MakeIProfile(ParameterValues v) {
  const double w = 0.5 * v[0], h = 0.5 * v[1], wall = LimitedWall(v[3], 0.3 * std::min(v[0], v[1]));
  const double web = 0.5 * wall, inner = h - wall;
  return {Extruded({{-w, -h},
                    {w, -h},
                    {w, -inner},
                    {web, -inner},
                    {web, inner},
                    {w, inner},
                    {w, h},
                    {-w, h},
                    {-w, inner},
                    {-web, inner},
                    {-web, -inner},
                    {-w, -inner}},
                   v[2]),
          wall};
}

constexpr auto kMachine = ShapeDomain::kMachine;
constexpr std::array kPipeRows{
    ShapeFamilyRow{"tube", "straight tube with open ends", kMachine, false, true, kTube, MakeTube,
                   2700},
    ShapeFamilyRow{"pipe", "pipe with open ends and a collar at one of them", kMachine, false, true,
                   kPipe, MakePipe, 2700},
    ShapeFamilyRow{"pipe_elbow", "bent pipe with open ends", kMachine, false, true, kPipeElbow,
                   MakePipeElbow, 2700},
    ShapeFamilyRow{"pipe_tee", "T of pipe with three open ends", kMachine, true, true, kPipeTee,
                   MakePipeTee, 2700},
    ShapeFamilyRow{"channel", "U profile", kMachine, false, true, kChannel, MakeChannel, 2700},
    ShapeFamilyRow{"i_profile", "I profile", kMachine, false, false, kIProfile, MakeIProfile, 2700},
};

}  // namespace

Solid CylinderAlongY(double radius, double length) {
  return Turned(Cylinder(radius, length), Eigen::Vector3d::UnitX(), 90);
}

Solid CylinderAlongX(double radius, double length) {
  return Turned(Cylinder(radius, length), Eigen::Vector3d::UnitY(), 90);
}

std::span<const ShapeFamilyRow> PipeFamilies() { return kPipeRows; }

}  // namespace pickbed::scenes
