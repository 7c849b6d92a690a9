#include "scenes/shape_families/solid_bounds.h"

#include <algorithm>
#include <vector>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

constexpr int kGrid = 32;           // points along each direction of a side
constexpr float kTouch_mm = 0.01f;  // the grid has arrived at this distance
constexpr int kMaxSteps = 400;

// The touched place: coordinate along the axis and position on the side.
struct Touch {
  float along = 0;
  float u = 0, v = 0;
  bool found = false;
};

// A square grid of points on a plane across an axis.
struct Sweep {
  int axis;
  float direction;  // of the movement along the axis
  float begin, end;
  Eigen::AlignedBox2f side;
};

Touch MoveGrid(const SolidProgram& program, const Sweep& sweep) {
  std::vector<Eigen::Vector3f> points(kGrid * kGrid);
  std::vector<float> distances(points.size());
  const int u_axis = (sweep.axis + 1) % 3, v_axis = (sweep.axis + 2) % 3;
  const Eigen::Vector2f step = sweep.side.sizes() / (kGrid - 1);
  for (int k = 0; k < kGrid * kGrid; ++k) {
    points[k][u_axis] = 1e-3f * (sweep.side.min().x() + step.x() * static_cast<float>(k % kGrid));
    points[k][v_axis] = 1e-3f * (sweep.side.min().y() + step.y() * static_cast<float>(k / kGrid));
  }
  float along = sweep.begin;
  for (int i = 0; i < kMaxSteps; ++i) {
    for (Eigen::Vector3f& p : points) p[sweep.axis] = 1e-3f * along;
    RunSolidProgram(program, Eigen::Vector3f::Zero(), points, distances);
    const auto nearest = std::min_element(distances.begin(), distances.end());
    if (*nearest <= kTouch_mm) {
      const Eigen::Vector3f& p = points[nearest - distances.begin()];
      return {along + sweep.direction * std::max(*nearest, 0.0f), 1e3f * p[u_axis],
              1e3f * p[v_axis], true};
    }
    along += sweep.direction * *nearest;
    if ((sweep.end - along) * sweep.direction < 0) return {};
  }
  return {along, 0, 0, true};
}

}  // namespace

Eigen::AlignedBox3f TightBox(const SolidProgram& program, const Eigen::AlignedBox3f& outer) {
  Eigen::AlignedBox3f tight = outer;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float direction : {1.0f, -1.0f}) {
      const int u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
      const float begin = (direction > 0 ? outer.min() : outer.max())[axis];
      const float end = (direction > 0 ? outer.max() : outer.min())[axis];
      const Eigen::AlignedBox2f side(Eigen::Vector2f(outer.min()[u_axis], outer.min()[v_axis]),
                                     Eigen::Vector2f(outer.max()[u_axis], outer.max()[v_axis]));
      Touch touch = MoveGrid(program, {axis, direction, begin, end, side});
      CheckInput(touch.found, "a solid is empty; check its cuts and intersections");
      const Eigen::Vector2f cell = side.sizes() / (kGrid - 1), at(touch.u, touch.v);
      const Touch fine = MoveGrid(program, {axis, direction, begin, end, {at - cell, at + cell}});
      if (fine.found && (touch.along - fine.along) * direction > 0) touch = fine;
      (direction > 0 ? tight.min() : tight.max())[axis] = touch.along;
    }
  }
  return tight;
}

}  // namespace pickbed::scenes
