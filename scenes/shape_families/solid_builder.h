#pragma once

// Builds solids from primitives: a tree in millimetres, compiled to a SolidShape.
//
//   const Solid cup = Cut(Cylinder(40, 90), Moved(Cylinder(37, 90), {0, 0, 3}));
//   const SolidShape shape = CompiledSolid(cup, 3);

#include <memory>
#include <span>
#include <vector>

#include "scenes/geometry/pose.h"
#include "scenes/shape_families/solid_shape.h"

namespace pickbed::scenes {

struct SolidNode;

// A node of the tree; copies share it.
class Solid {
 public:
  explicit Solid(std::shared_ptr<const SolidNode> node) : node_(std::move(node)) {}
  const SolidNode& node() const { return *node_; }
  const std::shared_ptr<const SolidNode>& shared() const { return node_; }

 private:
  std::shared_ptr<const SolidNode> node_;
};

using OutlineMm = std::vector<Eigen::Vector2d>;  // corners of a closed polygon, mm

// ---- Primitives, centered at the origin, lengths in mm ----

// Full sizes along x, y and z; edges are rounded by `radius`.
Solid Box(const Eigen::Vector3d& size, double radius = 0);
// About z, of full height; edges are rounded by `rounding`.
Solid Cylinder(double radius, double height, double rounding = 0);
// About z, with its two radii at -height/2 and height/2.
Solid Frustum(double low_radius, double high_radius, double height);
Solid Sphere(double radius);
// About z; `length` is the distance of the two sphere centers.
Solid Capsule(double radius, double length);
// About z.
Solid Torus(double circle_radius, double tube_radius);
// |x/a|^(2/e_xy) + |y/b|^(2/e_xy) = s, s^(e_xy/e_z) + |z/c|^(2/e_z) = 1, with exponents 0.1 to 1.9
// (Barr 1981): small is a box, 1 an ellipsoid, above 1 pinched.
Solid Superquadric(const Eigen::Vector3d& half_axes, double e_xy, double e_z);
// A polygon in xy, extruded to z = -height/2 .. height/2.
Solid Extruded(const OutlineMm& outline, double height);
// A polygon of (distance from the z axis, z), revolved about z. Distances are not negative.
Solid Revolved(const OutlineMm& outline);
// All points with normal . p <= offset.
Solid HalfSpace(const Eigen::Vector3d& normal, double offset);
// Intersection of half spaces: normal (any length) in the first three values, then the offset.
Solid Polyhedron(const std::vector<Eigen::Vector4d>& planes);
// Infinite wedge about z, within angle_deg / 2 of the x axis on each side; 0 < angle_deg < 360.
Solid Sector(double angle_deg);
// Regular prism about z with a flat side towards x; `across` is the distance of opposite sides.
Solid RegularPrism(int sides, double across, double height);
// Part of a ring about z with a round section: a bend of a rod, symmetric to x.
Solid Bend(double circle_radius, double tube_radius, double angle_deg);
// Spur gear about z: trapezoid teeth between the two radii.
Solid Gear(int teeth, double root_radius, double tip_radius, double height);

// ---- Combinations ----

Solid Union(const Solid& a, const Solid& b);
Solid Union(const std::vector<Solid>& solids);
Solid Cut(const Solid& a, const Solid& b);  // a without b
Solid Intersect(const Solid& a, const Solid& b);
// Union with a fillet of about this width where the surfaces meet.
Solid SmoothUnion(const Solid& a, const Solid& b, double fillet);
// Moves the surface outwards by `distance`; negative = inwards.
Solid Grown(const Solid& a, double distance);
// Keeps a wall of at least this thickness inside the surface. The cavity is closed.
Solid Shelled(const Solid& a, double thickness);

// ---- Placement ----

Solid Moved(const Solid& a, const Eigen::Vector3d& offset);
Solid Turned(const Solid& a, const Eigen::Vector3d& axis, double angle_deg);
Solid Placed(const Solid& a, const Pose& X_PA);  // translation in mm
// `count` copies about z. Only the part within 180/count degrees of the x axis is copied, together
// with its mirror image in the xz plane.
Solid Copies(const Solid& a, int count);
// The part of `a` with positive coordinates, and its mirror images in these axes.
Solid Mirrored(const Solid& a, bool x, bool y, bool z);

// Compiles the tree. `min_wall_mm` is the thickness of the thinnest wall. The result is scaled to
// metres and its origin is the center of the bounding box. Throws InputError if the solid is empty
// or larger than 2 m.
SolidShape CompiledSolid(const Solid& solid, double min_wall_mm);

}  // namespace pickbed::scenes
