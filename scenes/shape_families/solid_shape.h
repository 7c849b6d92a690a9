#pragma once

// A solid as a program of signed distances: the occupancy oracle of a sampled shape.
//
// The program combines primitives by union, cut and intersection (constructive solid geometry). Its
// value at a point has the exact sign: negative inside, positive outside. Its magnitude is at most
// the distance to the surface and it changes by at most 1 m per metre, so sphere tracing never
// passes through the surface (Hart, "Sphere Tracing", The Visual Computer 1996). Exact distances of
// the primitives: https://iquilezles.org/articles/distfunctions.
//
// solid_builder.h makes solids, shape_family.h samples them from distributions.

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "scenes/shape_families/solid_program.h"

namespace pickbed::scenes {

// A closed solid in its frame O. The origin is the center of its bounding box. It is a value and
// may be evaluated by several threads at once.
class SolidShape {
 public:
  // An empty solid: every distance is infinite.
  SolidShape() = default;
  // `program` works in millimetres in frame P. `box_P` is the bounding box of its solid and
  // `min_wall_mm` its thinnest wall. CompiledSolid() of solid_builder.h calls this.
  SolidShape(SolidProgram program, const Eigen::AlignedBox3f& box_P, float min_wall_mm);

  // Returns a bound of the signed distance from the surface to p_O (m), in m: negative inside.
  float SignedDistance_m(const Eigen::Vector3f& p_O) const;
  // Returns whether p_O (m) is inside the solid or on its surface.
  bool Contains(const Eigen::Vector3f& p_O) const { return SignedDistance_m(p_O) <= 0; }

  // Same as SignedDistance_m for many points (m). It is several times faster for 16 points or more.
  // `distances_m` must have the size of `points_O`. A value does not depend on the other points.
  void SignedDistances_m(std::span<const Eigen::Vector3f> points_O,
                         std::span<float> distances_m) const;

  // Returns the outward directions of the surface near the points (m), of unit length, by central
  // differences over `step_m`. A direction is zero where the distance has no slope.
  std::vector<Eigen::Vector3f> Normals(std::span<const Eigen::Vector3f> points_O,
                                       float step_m = 1e-4f) const;

  const Eigen::AlignedBox3f& box_O() const { return box_O_; }  // m, tight to about 0.05 mm
  float min_wall_m() const { return 1e-3f * min_wall_mm_; }    // thinnest wall or rod
  const SolidProgram& program() const { return program_; }
  // Returns a hash of the program and its parameters.
  uint64_t hash() const;

 private:
  SolidProgram program_;
  Eigen::Vector3f center_mm_ = Eigen::Vector3f::Zero();  // O in P
  Eigen::AlignedBox3f box_O_;
  float min_wall_mm_ = 0;
};

}  // namespace pickbed::scenes
