#include <cmath>

#include "scenes/base/math.h"
#include "scenes/part_families/family_makers.h"
#include "scenes/part_families/shapes.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = kRadiansPerDegree;
constexpr FamilyMaterial kAluminium{2700, 0.5, {182, 186, 192}};
constexpr FamilyMaterial kSteel{7800, 0.45, {120, 124, 130}};

Loop InPlaneX(double x, const Outline& yz) {
  Loop loop;
  for (const Vector2d& p : yz) loop.emplace_back(x, p.x(), p.y());
  return loop;
}

Loop InPlaneY(double y, const Outline& xz) {
  Loop loop;
  for (const Vector2d& p : xz) loop.emplace_back(p.x(), y, p.y());
  return loop;
}

// An angle bracket: the base is in the xy plane, the wall in the yz plane, and a rib between them.
struct BracketSize {
  double length = 80, width = 40, height = 50, thick = 6;
  double rib_y0 = 22, rib_y1 = 28, rib_reach = 24;
  Vector2d base_hole{62, 12};
  double base_hole_radius = 5;
  Vector2d wall_hole{13, 34};  // (y, z)
  double wall_hole_radius = 6;
  Vector2d boss{60, 28};
  double boss_radius = 8, boss_height = 8;
};

void AddBracketBase(const BracketSize& s, ShellBuilder& shell) {
  const double rib_end = s.thick + s.rib_reach;
  const Outline top = {{s.thick, 0},        {s.length, 0},       {s.length, s.width},
                       {s.thick, s.width},  {s.thick, s.rib_y1}, {rib_end, s.rib_y1},
                       {rib_end, s.rib_y0}, {s.thick, s.rib_y0}};
  const Outline bottom = {{0, 0}, {s.length, 0}, {s.length, s.width}, {0, s.width}};
  const Outline hole = CircleOutline(s.base_hole, s.base_hole_radius, 24);
  const Outline boss = CircleOutline(s.boss, s.boss_radius, 32);
  const double boss_z = s.thick + s.boss_height;
  shell.Face(AtHeight(top, s.thick), {AtHeight(hole, s.thick), AtHeight(boss, s.thick)});
  shell.Face(Reversed(AtHeight(bottom, 0)), {AtHeight(hole, 0)});
  shell.Band(AtHeight(hole, s.thick), AtHeight(hole, 0));
  shell.Band(AtHeight(boss, s.thick), AtHeight(boss, boss_z));
  shell.Face(AtHeight(boss, boss_z));
  shell.Face(InPlaneX(s.length, {{0, 0}, {s.width, 0}, {s.width, s.thick}, {0, s.thick}}));
}

void AddBracketWall(const BracketSize& s, ShellBuilder& shell) {
  const double rib_top = s.thick + s.rib_reach;
  const Outline front = {{0, s.thick},        {s.rib_y0, s.thick}, {s.rib_y0, rib_top},
                         {s.rib_y1, rib_top}, {s.rib_y1, s.thick}, {s.width, s.thick},
                         {s.width, s.height}, {0, s.height}};
  const Outline back = {{0, 0}, {s.width, 0}, {s.width, s.height}, {0, s.height}};
  const Outline hole = CircleOutline(s.wall_hole, s.wall_hole_radius, 24);
  shell.Face(InPlaneX(s.thick, front), {InPlaneX(s.thick, hole)});
  shell.Face(Reversed(InPlaneX(0, back)), {InPlaneX(0, hole)});
  shell.Band(InPlaneX(s.thick, hole), InPlaneX(0, hole));
  const Outline top = {{0, 0}, {s.thick, 0}, {s.thick, s.width}, {0, s.width}};
  shell.Face(AtHeight(top, s.height));
}

}  // namespace

FamilyObject MakeBracket() {
  const BracketSize s;
  const double rib_end = s.thick + s.rib_reach;
  const Outline profile = {
      {0, 0},       {s.length, 0}, {s.length, s.thick}, {s.thick, s.thick}, {s.thick, s.height},
      {0, s.height}};
  const Outline rib = {{s.thick, s.thick}, {rib_end, s.thick}, {s.thick, rib_end}};
  ShellBuilder shell;
  AddBracketBase(s, shell);
  AddBracketWall(s, shell);
  shell.Face(InPlaneY(0, profile));
  shell.Face(Reversed(InPlaneY(s.width, profile)));
  const Loop rib_near = InPlaneY(s.rib_y0, rib), rib_far = InPlaneY(s.rib_y1, rib);
  shell.Face(rib_near);
  shell.Face(Reversed(rib_far));
  shell.Quad(rib_near[1], rib_far[1], rib_far[2], rib_near[2]);

  const std::vector<ConvexPiece> pieces = {
      BoxPiece({0, 0, 0}, {s.length, s.width, s.thick}),
      BoxPiece({0, 0, s.thick}, {s.thick, s.width, s.height}), LoftPiece(rib_near, rib_far),
      PrismPiece(CircleOutline(s.boss, s.boss_radius, 16), s.thick, s.thick + s.boss_height)};
  return FinishObject(shell.Build(kCrease_deg), pieces, {}, kAluminium);
}

// A U of sheet metal with hooks at the ends of its arms. Its outline is in xz, extruded along y.
FamilyObject MakeUClip() {
  const double half = 20, inner = 15, floor = 5, top = 40, hook = 36, tip = 12, flat = 17;
  const double width = 24, corner = 5;
  const double slope = (top - hook) / (flat - tip);
  const double hook_root = hook + slope * (inner - tip);
  Outline base = Arc({half - corner, corner}, corner, -90 * kDegree, 0, 6);
  const Outline left = Arc({corner - half, corner}, corner, 180 * kDegree, 270 * kDegree, 6);
  base.insert(base.end(), left.begin(), left.end());
  Outline outline = Arc({half - corner, corner}, corner, -90 * kDegree, 0, 6);
  outline.insert(outline.end(), {{half, top},
                                 {flat, top},
                                 {tip, hook},
                                 {inner, hook},
                                 {inner, floor},
                                 {-inner, floor},
                                 {-inner, hook},
                                 {-tip, hook},
                                 {-flat, top},
                                 {-half, top}});
  outline.insert(outline.end(), left.begin(), left.end());

  const Outline arm = {{inner, floor}, {half, floor}, {half, top}, {flat, top}, {inner, hook_root}};
  const Outline barb = {{inner, hook}, {inner, hook_root}, {tip, hook}};
  std::vector<ConvexPiece> pieces;
  for (const Outline& piece : {base, arm, barb}) {
    pieces.push_back(PrismPiece(piece, -width / 2, width / 2));
  }
  for (int i : {1, 2}) {
    ConvexPiece mirrored = pieces[i];
    for (Vector3d& p : mirrored.vertices_O) p.x() = -p.x();
    pieces.push_back(mirrored);
  }
  ShellBuilder shell;
  shell.Prism(outline, {}, -width / 2, width / 2);
  const Pose upright = Frame(Vector3d::UnitX(), -Vector3d::UnitY());
  shell.Transform(upright);
  MovePieces(upright, pieces);
  return FinishObject(shell.Build(kCrease_deg), pieces, {CyclicZ(2), {}},
                      {7800, 0.45, {196, 150, 70}});
}

FamilyObject MakeHexBolt() {
  const double flats = 19, head = 8, bevel = 1, shaft_radius = 6, shaft = 45, chamfer = 1;
  const double corner = flats / std::sqrt(3);
  const Loop hex0 = Circle(corner, 6, 0), hex1 = Circle(corner, 6, head - bevel);
  const Loop hex2 = Circle(corner - bevel, 6, head);
  const int facets = 36;  // a multiple of 6, so that the symmetry is exact
  const double end_radius = shaft_radius - chamfer;
  const Loop neck = Circle(shaft_radius, facets, 0);
  const Loop chamfer_top = Circle(shaft_radius, facets, chamfer - shaft);
  const Loop end = Circle(end_radius, facets, -shaft);
  ShellBuilder shell;
  shell.Face(Reversed(hex0), {neck});
  shell.Band(hex0, hex1);
  shell.Band(hex1, hex2);
  shell.Face(hex2);
  const Loop center = Circle(shaft_radius, facets, (chamfer - shaft) / 2);
  shell.Band(chamfer_top, center);
  shell.Band(center, neck);
  shell.Band(end, chamfer_top);
  shell.Face(Reversed(end));

  ConvexPiece head_piece = LoftPiece(hex0, hex1);
  head_piece.vertices_O.insert(head_piece.vertices_O.end(), hex2.begin(), hex2.end());
  ConvexPiece shaft_piece = DiscPiece(shaft_radius, shaft_radius, chamfer - shaft, 0, 10);
  const Loop tip = Circle(end_radius, 10, -shaft);
  shaft_piece.vertices_O.insert(shaft_piece.vertices_O.end(), tip.begin(), tip.end());
  return FinishObject(shell.Build(25), {head_piece, shaft_piece}, {CyclicZ(6), {}}, kSteel);
}

FamilyObject MakeFlange() {
  const double radius = 40, thick = 8, hub_radius = 18, height = 24, bore = 10;
  const double hole_circle = 29, hole_radius = 3.5;
  const int holes = 6, facets = 60;
  const Loop rim0 = Circle(radius, facets, 0), rim1 = Circle(radius, facets, thick);
  const Loop hub1 = Circle(hub_radius, 48, thick), hub2 = Circle(hub_radius, 48, height);
  const Loop bore0 = Circle(bore, 36, 0), bore2 = Circle(bore, 36, height);
  ShellBuilder shell;
  std::vector<Loop> bottom_holes = {bore0}, top_holes = {hub1};
  for (int i = 0; i < holes; ++i) {
    const double angle = 2 * M_PI * i / holes;
    const Vector2d center(hole_circle * std::cos(angle), hole_circle * std::sin(angle));
    const Outline hole = CircleOutline(center, hole_radius, 18);
    bottom_holes.push_back(AtHeight(hole, 0));
    top_holes.push_back(AtHeight(hole, thick));
    shell.Band(top_holes.back(), bottom_holes.back());
  }
  shell.Face(Reversed(rim0), bottom_holes);
  shell.Face(rim1, top_holes);
  shell.Band(rim0, rim1);
  shell.Band(hub1, hub2);
  shell.Face(hub2, {bore2});
  shell.Band(bore2, bore0);

  std::vector<ConvexPiece> pieces = RingPieces({.inner_radius = bore,
                                                .outer_radius = radius,
                                                .z0 = 0,
                                                .z1 = thick,
                                                .sectors = 8,
                                                .outer_segments = 6});
  AppendPieces(RingPieces({.inner_radius = bore,
                           .outer_radius = hub_radius,
                           .z0 = thick,
                           .z1 = height,
                           .sectors = 8}),
               pieces);
  return FinishObject(shell.Build(kCrease_deg), pieces, {CyclicZ(holes), {}},
                      {2700, 0.5, {150, 160, 176}});
}

FamilyObject MakeGear() {
  const int teeth = 12;
  const double root = 24.5, pitch = 30, tip = 34.5, bore = 6.5, width = 14;
  const double root_half = 9.5 * kDegree, pitch_half = 7.5 * kDegree, tip_half = 3.8 * kDegree;
  const std::vector<Vector2d> tooth = {{root, -root_half}, {pitch, -pitch_half}, {tip, -tip_half},
                                       {tip, tip_half},    {pitch, pitch_half},  {root, root_half}};
  Outline outline;
  std::vector<ConvexPiece> pieces;
  for (int i = 0; i < teeth; ++i) {
    Outline one;
    for (const Vector2d& polar : tooth) {
      const double angle = polar.y() + 2 * M_PI * i / teeth;
      one.emplace_back(polar.x() * std::cos(angle), polar.x() * std::sin(angle));
    }
    outline.insert(outline.end(), one.begin(), one.end());
    pieces.push_back(PrismPiece(one, -width / 2, width / 2));
  }
  AppendPieces(RingPieces({.inner_radius = bore,
                           .outer_radius = root,
                           .z0 = -width / 2,
                           .z1 = width / 2,
                           .sectors = 6,
                           .begin_rad = M_PI / teeth,
                           .outer_segments = 6}),
               pieces);
  ShellBuilder shell;
  shell.Prism(outline, {CircleOutline({0, 0}, bore, 36)}, -width / 2, width / 2);
  return FinishObject(shell.Build(25), pieces, {DihedralZ(teeth), {}}, {7800, 0.5, {96, 100, 108}});
}

FamilyObject MakeRing() {
  const double inner = 22, outer = 30, height = 14, bevel = 0.6;
  const Outline profile = {{inner, -height / 2},        {outer - bevel, -height / 2},
                           {outer, bevel - height / 2}, {outer, 0},
                           {outer, height / 2 - bevel}, {outer - bevel, height / 2},
                           {inner, height / 2},         {inner, 0}};
  ShellBuilder shell;
  shell.RevolveRing(profile, 72);
  const std::vector<ConvexPiece> pieces = RingPieces({.inner_radius = inner,
                                                      .outer_radius = outer,
                                                      .z0 = -height / 2,
                                                      .z1 = height / 2,
                                                      .sectors = 16});
  return FinishObject(shell.Build(kCrease_deg), pieces,
                      {{Turn(Vector3d::UnitX(), 180)}, {ContinuousSymmetry{}}},
                      {8500, 0.45, {200, 168, 88}});
}

}  // namespace pickbed::scenes
