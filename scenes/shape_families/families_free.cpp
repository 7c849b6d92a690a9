#include <array>

#include "scenes/base/random.h"
#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector3d;

constexpr std::array<ShapeParameter, 5> kSuperquadric{{{"length", 40, 150},
                                                       {"width", 30, 90},
                                                       {"height", 25, 75},
                                                       {"e_xy", 0.3, 1.2},
                                                       {"e_z", 0.3, 1.2}}};
FamilySolid MakeSuperquadric(ParameterValues v) {
  const Vector3d half = 0.5 * Vector3d(v[0], v[1], v[2]);
  const auto exponent = [](double e) { return std::clamp(e, 0.15, 1.5); };
  return {Superquadric(half, exponent(v[3]), exponent(v[4])), 2 * half.minCoeff()};
}

// A primitive of about `size_mm`, in a random orientation.
Solid RandomPrimitive(double size_mm, Rng& rng) {
  const auto length = [&] { return size_mm * rng.Uniform(0.35, 1); };
  const double a = length(), b = length(), c = length();
  Solid solid = Box({a, b, c}, 0.1 * std::min({a, b, c}));
  switch (rng.Index(5)) {
    case 0:
      break;
    case 1:
      solid = Cylinder(0.5 * a, b);
      break;
    case 2:
      solid = Superquadric({0.5 * a, 0.5 * b, 0.5 * c}, rng.Uniform(0.3, 1), 1);
      break;
    case 3:
      solid = Cut(Cylinder(0.5 * a, b), Cylinder(0.5 * a - std::max(0.15 * a, 3.0), 2 * b));
      break;
    case 4:
      solid = Torus(0.5 * a, std::max(0.12 * a, 3.0));
      break;
  }
  return Turned(solid, rng.UnitVector(), rng.Uniform(0, 180));
}

constexpr std::array<ShapeParameter, 3> kRandomUnion{
    {{"size", 50, 110}, {"pieces", 2, 5, true}, {"pattern", 0, 999999, true}}};
// Primitives in random poses. Each one begins inside of the one before, so that they are connected.
FamilySolid MakeRandomUnion(ParameterValues v) {
  Rng rng = Rng::Derive(static_cast<uint64_t>(v[2] + 1e6), 0, "random union");
  const double size = v[0];
  const int pieces = std::max(1, static_cast<int>(v[1]));
  Solid solid = Box(0.3 * size * Vector3d(rng.Uniform(0.5, 1), rng.Uniform(0.5, 1), 1));
  Vector3d center = Vector3d::Zero();
  for (int i = 0; i < pieces; ++i) {
    const Solid piece = Moved(RandomPrimitive(0.7 * size, rng), center);
    // A bar from the center makes sure that hollow primitives touch the others.
    const Vector3d next = center + 0.45 * size * rng.UnitVector();
    const Solid bar =
        Moved(Placed(Capsule(0.06 * size + 2, (next - center).norm()),
                     MakePose(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), next - center)
                                  .toRotationMatrix(),
                              Vector3d::Zero())),
              0.5 * (center + next));
    solid = SmoothUnion(Union(solid, piece), bar, 3);
    center = next;
  }
  return {solid, 3};
}

constexpr std::array kFreeRows{
    ShapeFamilyRow{"random_union", "random union of primitives", ShapeDomain::kMachine, false,
                   false, kRandomUnion, MakeRandomUnion, 1200},
    ShapeFamilyRow{"superquadric", "superquadric, from a box to an ellipsoid and a lens",
                   ShapeDomain::kSupermarket, false, false, kSuperquadric, MakeSuperquadric, 900},
};

}  // namespace

std::span<const ShapeFamilyRow> FreeFamilies() { return kFreeRows; }

}  // namespace pickbed::scenes
