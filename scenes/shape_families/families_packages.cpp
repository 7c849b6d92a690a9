#include <array>
#include <cmath>
#include <numbers>

#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

constexpr std::array<ShapeParameter, 3> kCarton{
    {{"width", 30, 95}, {"depth", 20, 70}, {"height", 45, 180}}};
FamilySolid MakeCarton(ParameterValues v) {
  return {Box({v[0], v[1], v[2]}, 0.6), std::min({v[0], v[1], v[2]})};
}

constexpr std::array<ShapeParameter, 4> kRoundedBox{
    {{"length", 50, 130}, {"width", 30, 75}, {"height", 18, 60}, {"radius_share", 0.3, 0.8}}};
FamilySolid MakeRoundedBox(ParameterValues v) {
  const double thinnest = std::min({v[0], v[1], v[2]});
  return {Box({v[0], v[1], v[2]}, 0.5 * thinnest * std::min(v[3], 0.95)), thinnest};
}

constexpr std::array<ShapeParameter, 4> kBottle{{{"radius", 20, 38},
                                                 {"height", 100, 200},
                                                 {"neck_share", 0.3, 0.5},
                                                 {"shoulder_share", 0.15, 0.35}}};
FamilySolid MakeBottle(ParameterValues v) {
  const double r = v[0], height = v[1], neck = r * v[2];
  const double cap = 0.1 * height, body = height * (0.8 - v[3]), neck_low = 0.8 * height;
  const double lift = neck_low - body;
  return {Revolved({{0, 0},
                    {r - 4, 0},
                    {r, 4},
                    {r, body},
                    {r - 0.25 * (r - neck), body + 0.4 * lift},
                    {r - 0.75 * (r - neck), body + 0.75 * lift},
                    {neck, neck_low},
                    {neck, height - cap},
                    {1.2 * neck, height - cap},
                    {1.2 * neck, height},
                    {0, height}}),
          2 * neck};
}

constexpr std::array<ShapeParameter, 4> kCan{
    {{"radius", 25, 43}, {"height", 40, 130}, {"rim", 2, 3.5}, {"recess", 2, 5}}};
// Both ends have a rim around a recess.
FamilySolid MakeCan(ParameterValues v) {
  const double r = v[0], h = 0.5 * std::max(v[1], 20.0), rim = LimitedWall(v[2], 5);
  const double recess = std::max(v[3], 1.0), inner = r - rim, body = r - 0.5 * rim;
  return {Revolved({{0, recess - h},
                    {inner, recess - h},
                    {inner, -h},
                    {r, -h},
                    {r, 1.5 * rim - h},
                    {body, 2 * rim - h},
                    {body, h - 2 * rim},
                    {r, h - 1.5 * rim},
                    {r, h},
                    {inner, h},
                    {inner, h - recess},
                    {0, h - recess}}),
          rim};
}

constexpr std::array<ShapeParameter, 4> kJar{
    {{"radius", 25, 43}, {"height", 55, 130}, {"lid_share", 0.8, 1.0}, {"lid_height", 9, 18}}};
FamilySolid MakeJar(ParameterValues v) {
  const double r = v[0], height = v[1], lid = r * v[2], top = height - v[3];
  const double neck = 0.9 * lid;
  return {Revolved({{0, 0},
                    {r - 3, 0},
                    {r, 3},
                    {r, top - 2 - 0.5 * (r - neck)},
                    {neck, top - 2},
                    {neck, top},
                    {lid, top},
                    {lid, height},
                    {0, height}}),
          2 * neck};
}

constexpr std::array<ShapeParameter, 4> kYogurtPot{
    {{"radius", 24, 42}, {"height", 45, 110}, {"taper", 0.65, 0.9}, {"rim", 2.5, 5}}};
FamilySolid MakeYogurtPot(ParameterValues v) {
  const double r = v[0], height = v[1], lip = 2.5;
  return {Revolved({{0, 0},
                    {r * v[2], 0},
                    {r, height - lip},
                    {r + v[3], height - lip},
                    {r + v[3], height},
                    {0, height}}),
          lip};
}

constexpr std::array<ShapeParameter, 4> kToothpasteTube{
    {{"radius", 13, 24}, {"length", 80, 170}, {"cap_share", 0.45, 0.8}, {"cap_length", 12, 30}}};
// The hull of a circle and of a line that is as long as half the circle, and a cap.
FamilySolid MakeToothpasteTube(ParameterValues v) {
  constexpr int kSides = 48;
  const double r = v[0], length = v[1], line = 0.5 * std::numbers::pi * r, fold = 2.5;
  std::vector<Eigen::Vector4d> planes = {{0, 0, -1, 0}, {0, 0, 1, length}};
  for (int k = 0; k < kSides; ++k) {
    const double angle = 2 * std::numbers::pi * k / kSides, c = std::cos(angle),
                 s = std::sin(angle);
    // The plane holds the circle's tangent at z = 0 and touches the thick line at z = length.
    const double reach = std::abs(c) * line + std::abs(s) * 0.5 * fold;
    planes.emplace_back(c, s, (r - reach) / length, r);
  }
  const double cap = r * v[2], cap_length = std::max(v[3], 5.0);
  const Solid screw = Moved(Frustum(0.85 * cap, cap, cap_length), {0, 0, -0.5 * cap_length});
  return {
      Union(Intersect(Polyhedron(planes), Moved(Box({4 * r, 4 * r, length}), {0, 0, 0.5 * length})),
            screw),
      fold};
}

constexpr std::array<ShapeParameter, 4> kTetraPack{
    {{"width", 40, 80}, {"depth", 35, 75}, {"height", 70, 150}, {"roof_share", 0.35, 0.6}}};
// A carton with a gable and a fin along its ridge.
FamilySolid MakeTetraPack(ParameterValues v) {
  const double w = v[0], d = 0.5 * v[1], height = v[2], roof = v[1] * v[3], fin = 10;
  const double half_fin = kMinWall_mm;
  const Solid house = Extruded({{-d, 0},
                                {d, 0},
                                {d, height},
                                {half_fin, height + roof},
                                {half_fin, height + roof + fin},
                                {-half_fin, height + roof + fin},
                                {-half_fin, height + roof},
                                {-d, height}},
                               w);
  return {house, 2 * half_fin};
}

constexpr std::array<ShapeParameter, 4> kBag{
    {{"length", 80, 170}, {"width", 55, 110}, {"thickness", 22, 55}, {"pinch", 1.15, 1.5}}};
FamilySolid MakeBag(ParameterValues v) {
  const double seam = 2;
  const Solid pillow = Superquadric({0.5 * v[0], 0.5 * v[1], 0.5 * v[2]}, 0.35, v[3]);
  const Solid seams = Box({v[0] + 8, 0.9 * v[1], seam});
  return {Union(pillow, seams), seam};
}

constexpr std::array<ShapeParameter, 3> kBanana{
    {{"bend_radius", 65, 115}, {"radius", 14, 21}, {"angle_deg", 60, 100}}};
FamilySolid MakeBanana(ParameterValues v) {
  const Solid tip = Turned(Moved(Sphere(v[1]), {v[0], 0, 0}), Eigen::Vector3d::UnitZ(), 0.5 * v[2]);
  return {Union(Bend(v[0], v[1], v[2]), Mirrored(tip, false, true, false)), v[1]};
}

constexpr auto kPackage = ShapeDomain::kSupermarket;
constexpr std::array kPackageRows{
    ShapeFamilyRow{"carton", "rectangular carton", kPackage, false, false, kCarton, MakeCarton,
                   400},
    ShapeFamilyRow{"rounded_box", "box with round edges, such as a piece of soap", kPackage, false,
                   false, kRoundedBox, MakeRoundedBox, 900},
    ShapeFamilyRow{"bottle", "closed bottle with a cap", kPackage, false, false, kBottle,
                   MakeBottle, 900},
    ShapeFamilyRow{"can", "can with rims", kPackage, false, false, kCan, MakeCan, 900},
    ShapeFamilyRow{"jar", "closed jar with a lid", kPackage, false, false, kJar, MakeJar, 1000},
    ShapeFamilyRow{"yogurt_pot", "closed pot with a lid that overhangs", kPackage, false, false,
                   kYogurtPot, MakeYogurtPot, 900},
    ShapeFamilyRow{"toothpaste_tube", "flat-ended tube with a cap", kPackage, true, false,
                   kToothpasteTube, MakeToothpasteTube, 900},
    ShapeFamilyRow{"tetra_pack", "drink carton with a gable", kPackage, true, false, kTetraPack,
                   MakeTetraPack, 900},
    ShapeFamilyRow{"bag", "pillow bag with two seams", kPackage, false, false, kBag, MakeBag, 300},
    ShapeFamilyRow{"banana", "bent rod with round ends", kPackage, false, false, kBanana,
                   MakeBanana, 900},
};

}  // namespace

std::span<const ShapeFamilyRow> PackageFamilies() { return kPackageRows; }

}  // namespace pickbed::scenes
