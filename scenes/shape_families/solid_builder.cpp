#include "scenes/shape_families/solid_builder.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "scenes/base/error.h"
#include "scenes/base/math.h"
#include "scenes/shape_families/solid_bounds.h"

namespace pickbed::scenes {

// A node holds one instruction, or only a pose if it has none.
struct SolidNode {
  std::optional<SolidInstruction> instruction;
  std::vector<Eigen::Vector2f> outline;
  std::vector<Eigen::Vector4f> planes;
  std::vector<Solid> children;
  Pose X_PN = Pose::Identity();  // mm; only of a node without an instruction
  Eigen::AlignedBox3d box;       // contains the solid, mm
};

namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kInfinite_mm = 1e5;  // half size of the box of an infinite solid
constexpr double kMaxSize_mm = 2000;

AlignedBox3d BoxAround(const Vector3d& half) { return {-half, half}; }

Solid MakeNode(SolidNode node) { return Solid(std::make_shared<const SolidNode>(std::move(node))); }

Solid Primitive(SolidOp op, std::initializer_list<double> values, const AlignedBox3d& box,
                SolidNode node = {}) {
  SolidInstruction instruction{.op = op};
  size_t i = 0;
  for (const double value : values) instruction.v[i++] = static_cast<float>(value);
  node.instruction = instruction;
  node.box = box;
  return MakeNode(std::move(node));
}

Solid Combination(SolidOp op, double value, std::vector<Solid> children, const AlignedBox3d& box) {
  SolidNode node;
  node.instruction = SolidInstruction{.op = op};
  node.instruction->v[0] = static_cast<float>(value);
  node.children = std::move(children);
  node.box = box;
  return MakeNode(std::move(node));
}

std::vector<Eigen::Vector2f> ToFloat(const OutlineMm& outline) {
  std::vector<Eigen::Vector2f> result;
  for (const Vector2d& p : outline) result.push_back(p.cast<float>());
  return result;
}

AlignedBox3d MovedBox(const AlignedBox3d& box, const Pose& X) {
  AlignedBox3d moved;
  for (int corner = 0; corner < 8; ++corner) {
    moved.extend(X * box.corner(static_cast<AlignedBox3d::CornerType>(corner)));
  }
  return moved;
}

// Returns the Lipschitz constant of a p-norm of two numbers relative to the Euclidean one.
double NormFactor(double exponent) { return exponent >= 2 ? 1 : std::pow(2.0, 1 / exponent - 0.5); }

void SetFrame(const Pose& X_PN, SolidInstruction& instruction) {
  const Pose X_NP = X_PN.inverse();
  for (int k = 0; k < 9; ++k) instruction.R[k] = static_cast<float>(X_NP.linear()(k / 3, k % 3));
  for (int k = 0; k < 3; ++k) instruction.t[k] = static_cast<float>(X_NP.translation()[k]);
}

// Appends the instructions of a node whose frame is X_PN in the current points' frame.
void Emit(const SolidNode& node, const Pose& X_PN, SolidProgram& program) {
  if (!node.instruction) {
    Emit(node.children.front().node(), X_PN * node.X_PN, program);
    return;
  }
  SolidInstruction instruction = *node.instruction;
  const bool pushes =
      instruction.op == SolidOp::kPushCopies || instruction.op == SolidOp::kPushMirror;
  if (pushes || node.children.empty()) SetFrame(X_PN, instruction);
  if (!node.outline.empty()) {
    instruction.first = static_cast<int>(program.outlines.size());
    instruction.count = static_cast<int>(node.outline.size());
    program.outlines.insert(program.outlines.end(), node.outline.begin(), node.outline.end());
  }
  if (!node.planes.empty()) {
    instruction.first = static_cast<int>(program.planes.size());
    instruction.count = static_cast<int>(node.planes.size());
    program.planes.insert(program.planes.end(), node.planes.begin(), node.planes.end());
  }
  if (pushes) {
    program.instructions.push_back(instruction);
    Emit(node.children.front().node(), Pose::Identity(), program);
    program.instructions.push_back({.op = SolidOp::kPopPoints});
    return;
  }
  for (const Solid& child : node.children) Emit(child.node(), X_PN, program);
  program.instructions.push_back(instruction);
}

}  // namespace

Solid Box(const Vector3d& size, double radius) {
  const Vector3d half = 0.5 * size;
  return Primitive(SolidOp::kBox, {half.x(), half.y(), half.z(), radius}, BoxAround(half));
}

Solid Cylinder(double radius, double height, double rounding) {
  return Primitive(SolidOp::kCylinder, {radius, 0.5 * height, rounding},
                   BoxAround({radius, radius, 0.5 * height}));
}

Solid Frustum(double low_radius, double high_radius, double height) {
  const double half = 0.5 * height;
  return Revolved({{0, -half}, {low_radius, -half}, {high_radius, half}, {0, half}});
}

Solid Sphere(double radius) { return Capsule(radius, 0); }

Solid Capsule(double radius, double length) {
  return Primitive(SolidOp::kCapsule, {radius, 0.5 * length},
                   BoxAround({radius, radius, radius + 0.5 * length}));
}

Solid Torus(double circle_radius, double tube_radius) {
  const double outer = circle_radius + tube_radius;
  return Primitive(SolidOp::kTorus, {circle_radius, tube_radius},
                   BoxAround({outer, outer, tube_radius}));
}

Solid Superquadric(const Vector3d& half_axes, double e_xy, double e_z) {
  const double n_xy = 2 / e_xy, n_z = 2 / e_z;
  const double slope = half_axes.minCoeff() / (NormFactor(n_xy) * NormFactor(n_z));
  return Primitive(SolidOp::kSuperquadric,
                   {half_axes.x(), half_axes.y(), half_axes.z(), n_xy, n_z, slope},
                   BoxAround(half_axes));
}

Solid Extruded(const OutlineMm& outline, double height) {
  SolidNode node;
  node.outline = ToFloat(outline);
  AlignedBox3d box;
  for (const Vector2d& p : outline) {
    box.extend(Vector3d(p.x(), p.y(), -0.5 * height));
    box.extend(Vector3d(p.x(), p.y(), 0.5 * height));
  }
  return Primitive(SolidOp::kExtruded, {0.5 * height}, box, std::move(node));
}

Solid Revolved(const OutlineMm& outline) {
  SolidNode node;
  node.outline = ToFloat(outline);
  AlignedBox3d box;
  for (const Vector2d& p : outline) {
    box.extend(Vector3d(-p.x(), -p.x(), p.y()));
    box.extend(Vector3d(p.x(), p.x(), p.y()));
  }
  return Primitive(SolidOp::kRevolved, {}, box, std::move(node));
}

Solid HalfSpace(const Vector3d& normal, double offset) {
  return Polyhedron({Vector4d(normal.x(), normal.y(), normal.z(), offset)});
}

Solid Polyhedron(const std::vector<Vector4d>& planes) {
  SolidNode node;
  AlignedBox3d box = BoxAround(Vector3d::Constant(kInfinite_mm));
  for (const Vector4d& plane : planes) {
    const Vector4d unit = plane / plane.head<3>().norm();
    node.planes.push_back(unit.cast<float>());
    for (int axis = 0; axis < 3; ++axis) {
      if (unit[axis] > 1 - 1e-9) box.max()[axis] = std::min(box.max()[axis], unit[3]);
      if (unit[axis] < -1 + 1e-9) box.min()[axis] = std::max(box.min()[axis], -unit[3]);
    }
  }
  return Primitive(SolidOp::kPlanes, {}, box, std::move(node));
}

Solid Sector(double angle_deg) {
  const double half_rad = Radians(0.5 * angle_deg);
  return Primitive(SolidOp::kSector, {std::cos(half_rad), std::sin(half_rad)},
                   BoxAround(Vector3d::Constant(kInfinite_mm)));
}

Solid RegularPrism(int sides, double across, double height) {
  std::vector<Vector4d> planes = {{0, 0, 1, 0.5 * height}, {0, 0, -1, 0.5 * height}};
  for (int k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    planes.emplace_back(std::cos(angle), std::sin(angle), 0, 0.5 * across);
  }
  const double corner = 0.5 * across / std::cos(std::numbers::pi / sides);
  SolidNode node = Polyhedron(planes).node();
  node.box = BoxAround({corner, corner, 0.5 * height});
  return MakeNode(std::move(node));
}

Solid Bend(double circle_radius, double tube_radius, double angle_deg) {
  return Intersect(Torus(circle_radius, tube_radius), Sector(angle_deg));
}

Solid Gear(int teeth, double root_radius, double tip_radius, double height) {
  const double pitch_rad = std::numbers::pi / teeth;  // half of one tooth and one gap
  const double root = root_radius * std::sin(0.56 * pitch_rad);
  const double tip = tip_radius * std::sin(0.30 * pitch_rad);
  const Solid tooth = Extruded({{0.5 * root_radius, -root},
                                {root_radius, -root},
                                {tip_radius, -tip},
                                {tip_radius, tip},
                                {root_radius, root},
                                {0.5 * root_radius, root}},
                               height);
  return Union(Cylinder(root_radius, height), Copies(tooth, teeth));
}

Solid Union(const Solid& a, const Solid& b) {
  return Combination(SolidOp::kUnion, 0, {a, b}, a.node().box.merged(b.node().box));
}

Solid Union(const std::vector<Solid>& solids) {
  Solid all = solids.at(0);
  for (size_t i = 1; i < solids.size(); ++i) all = Union(all, solids[i]);
  return all;
}

Solid Cut(const Solid& a, const Solid& b) {
  return Combination(SolidOp::kCut, 0, {a, b}, a.node().box);
}

Solid Intersect(const Solid& a, const Solid& b) {
  return Combination(SolidOp::kIntersect, 0, {a, b}, a.node().box.intersection(b.node().box));
}

Solid SmoothUnion(const Solid& a, const Solid& b, double fillet) {
  AlignedBox3d box = a.node().box.merged(b.node().box);
  const Vector3d grown = Vector3d::Constant(0.25 * fillet);
  box.min() -= grown;
  box.max() += grown;
  return Combination(SolidOp::kSmoothUnion, fillet, {a, b}, box);
}

Solid Grown(const Solid& a, double distance) {
  AlignedBox3d box = a.node().box;
  // The box of an inward offset is kept, because a bound of the distance may move less.
  const Vector3d grown = Vector3d::Constant(std::max(distance, 0.0));
  box.min() -= grown;
  box.max() += grown;
  return Combination(SolidOp::kOffset, distance, {a}, box);
}

Solid Shelled(const Solid& a, double thickness) {
  return Combination(SolidOp::kShell, thickness, {a}, a.node().box);
}

Solid Moved(const Solid& a, const Vector3d& offset) { return Placed(a, Translation(offset)); }

Solid Turned(const Solid& a, const Vector3d& axis, double angle_deg) {
  const Eigen::AngleAxisd turn(Radians(angle_deg), axis.normalized());
  return Placed(a, MakePose(turn.toRotationMatrix(), Vector3d::Zero()));
}

Solid Placed(const Solid& a, const Pose& X_PA) {
  SolidNode node;
  node.children = {a};
  node.X_PN = X_PA;
  node.box = MovedBox(a.node().box, X_PA);
  return MakeNode(std::move(node));
}

Solid Copies(const Solid& a, int count) {
  SolidNode node;
  node.instruction = SolidInstruction{.op = SolidOp::kPushCopies};
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    node.outline.emplace_back(std::cos(angle), std::sin(angle));
  }
  node.children = {a};
  const AlignedBox3d& box = a.node().box;
  const Vector3d far = box.max().cwiseAbs().cwiseMax(box.min().cwiseAbs());
  const double radius = std::hypot(far.x(), far.y());
  node.box = AlignedBox3d(Vector3d(-radius, -radius, box.min().z()),
                          Vector3d(radius, radius, box.max().z()));
  return MakeNode(std::move(node));
}

Solid Mirrored(const Solid& a, bool x, bool y, bool z) {
  SolidNode node;
  node.instruction = SolidInstruction{.op = SolidOp::kPushMirror};
  const std::array<bool, 3> axes{x, y, z};
  node.box = a.node().box;
  for (int axis = 0; axis < 3; ++axis) {
    if (!axes[axis]) continue;
    node.instruction->v[axis] = 1;
    node.box.min()[axis] = -node.box.max()[axis];
  }
  node.children = {a};
  return MakeNode(std::move(node));
}

SolidShape CompiledSolid(const Solid& solid, double min_wall_mm) {
  SolidProgram program;
  Emit(solid.node(), Pose::Identity(), program);
  CheckInput(program.IsValid(), "a solid is nested too deeply; combine fewer solids at once");
  const AlignedBox3d& outer = solid.node().box;
  CheckInput(
      !outer.isEmpty() && outer.sizes().maxCoeff() <= kMaxSize_mm,
      fmt::format("a solid is empty or larger than {:g} mm; intersect it with a box", kMaxSize_mm));
  const Eigen::AlignedBox3f box = TightBox(program, outer.cast<float>());
  return SolidShape(std::move(program), box, static_cast<float>(min_wall_mm));
}

}  // namespace pickbed::scenes
