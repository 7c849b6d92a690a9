#pragma once

// The instructions of a signed-distance program and their evaluation for blocks of points.
//
// It is a stack machine. A primitive pushes the distances of all points of the block; a combination
// replaces the top two. A second stack holds the points: copies and mirrors push folded points for
// the instructions up to the matching kPopPoints.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pickbed::scenes {

enum class SolidOp : uint8_t {
  // Primitives; their frame is given by `R` and `t`. Lengths in mm, v = values.
  kBox,           // v: half sizes x y z, radius of the edges
  kCylinder,      // about z; v: radius, half height, radius of the edges
  kCapsule,       // along z; v: radius, half length of the axis
  kTorus,         // about z; v: radius of the circle, radius of the tube
  kSuperquadric,  // v: half axes x y z, exponents 2/e of the section in xy and along z, slope bound
  kExtruded,      // outline in xy, v: half height
  kRevolved,      // outline in (distance from z, z)
  kPlanes,        // intersection of half spaces; also a single one
  kSector,        // about z, symmetric to x; v: cos and sin of the half angle
  // Combinations of the top two values, of which b is the last.
  kUnion,
  kCut,  // a without b
  kIntersect,
  kSmoothUnion,  // v: width of the fillet
  // Changes of the last value.
  kOffset,  // v: distance by which the surface moves outwards
  kShell,   // v: thickness of the wall inside the surface
  // Changes of the points.
  kPushCopies,  // `count` copies about z; the child is in the sector about x
  kPushMirror,  // v: 1 for each axis whose negative half mirrors the positive one
  kPopPoints,
};

// One instruction. `first` and `count` are a range of the program's outline points or planes.
struct SolidInstruction {
  SolidOp op = SolidOp::kBox;
  int first = 0;
  int count = 0;
  std::array<float, 9> R{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row by row: p_own = R p + t
  std::array<float, 3> t{0, 0, 0};                    // mm
  std::array<float, 6> v{};
};

// Limits of the two stacks.
inline constexpr int kSolidValues = 24;
inline constexpr int kSolidPoints = 6;

struct SolidProgram {
  std::vector<SolidInstruction> instructions;
  std::vector<Eigen::Vector2f> outlines;  // mm; closed polygons
  std::vector<Eigen::Vector4f> planes;    // unit normal and offset in mm: n p <= offset inside

  // Returns whether the stacks stay within their limits and one value remains.
  bool IsValid() const;
};

// Evaluates a valid program: distances (mm) of points (m), which are first moved by `offset_mm`.
void RunSolidProgram(const SolidProgram& program, const Eigen::Vector3f& offset_mm,
                     std::span<const Eigen::Vector3f> points_m, std::span<float> distances_mm);

}  // namespace pickbed::scenes
