#include "scenes/shape_families/solid_bounds.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

constexpr int kGrid = 24;           // points along each direction of a side
constexpr float kTouch_mm = 0.01f;  // the grid has arrived at this distance
constexpr int kMaxSteps = 400;
constexpr float kBefore = 1.5f;  // cells between the touched plane and a peak between the points
constexpr int kPlaces = 4;       // that are searched for a peak

// A square grid of points on a plane across an axis.
struct Sweep {
  int axis;
  float direction;  // of the movement along the axis
  float begin, end;
  Eigen::AlignedBox2f side;
};

class SweptGrid {
 public:
  SweptGrid(const SolidProgram& program, const Sweep& sweep)
      : program_(program), sweep_(sweep), points_(kGrid * kGrid), distances_(points_.size()) {
    const Eigen::Vector2f step = sweep.side.sizes() / (kGrid - 1);
    for (int k = 0; k < kGrid * kGrid; ++k) {
      points_[k][(sweep.axis + 1) % 3] =
          1e-3f * (sweep.side.min().x() + step.x() * static_cast<float>(k % kGrid));
      points_[k][(sweep.axis + 2) % 3] =
          1e-3f * (sweep.side.min().y() + step.y() * static_cast<float>(k / kGrid));
    }
  }

  // Returns the coordinate at which a point touches the solid, or `end` if none does.
  float Touch() {
    float along = sweep_.begin;
    for (int i = 0; i < kMaxSteps; ++i) {
      const float nearest = EvaluateAt(along);
      if (nearest <= kTouch_mm) return along + sweep_.direction * std::max(nearest, 0.0f);
      along += sweep_.direction * nearest;
      if ((sweep_.end - along) * sweep_.direction <= 0) return sweep_.end;
    }
    return along;
  }

  // Returns the positions on the side of the points that are nearest to the solid on the plane at
  // `along`, nearest first and at least two cells apart.
  std::vector<Eigen::Vector2f> Nearest(float along, int count) {
    EvaluateAt(along);
    std::vector<Eigen::Vector2f> places;
    for (int i = 0; i < count; ++i) {
      const int k = static_cast<int>(std::min_element(distances_.begin(), distances_.end()) -
                                     distances_.begin());
      places.emplace_back(1e3f * points_[k][(sweep_.axis + 1) % 3],
                          1e3f * points_[k][(sweep_.axis + 2) % 3]);
      const int row = k / kGrid, column = k % kGrid;
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, kGrid - 1); ++r) {
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, kGrid - 1); ++c) {
          distances_[r * kGrid + c] = std::numeric_limits<float>::max();
        }
      }
    }
    return places;
  }

 private:
  float EvaluateAt(float along) {
    for (Eigen::Vector3f& p : points_) p[sweep_.axis] = 1e-3f * along;
    RunSolidProgram(program_, Eigen::Vector3f::Zero(), points_, distances_);
    return *std::min_element(distances_.begin(), distances_.end());
  }

  const SolidProgram& program_;
  Sweep sweep_;
  std::vector<Eigen::Vector3f> points_;  // m
  std::vector<float> distances_;         // mm
};

}  // namespace

Eigen::AlignedBox3f TightBox(const SolidProgram& program, const Eigen::AlignedBox3f& outer) {
  Eigen::AlignedBox3f tight = outer;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float direction : {1.0f, -1.0f}) {
      const int u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
      Sweep sweep;
      sweep.axis = axis;
      sweep.direction = direction;
      sweep.begin = (direction > 0 ? outer.min() : outer.max())[axis];
      sweep.end = (direction > 0 ? outer.max() : outer.min())[axis];
      sweep.side = {Eigen::Vector2f(outer.min()[u_axis], outer.min()[v_axis]),
                    Eigen::Vector2f(outer.max()[u_axis], outer.max()[v_axis])};
      SweptGrid coarse(program, sweep);
      float touched = coarse.Touch();
      CheckInput(touched != sweep.end, "a solid is empty; check its cuts and intersections");
      const Eigen::Vector2f cell = sweep.side.sizes() / (kGrid - 1);
      const float before = touched - direction * kBefore * cell.maxCoeff();
      for (const Eigen::Vector2f& place : coarse.Nearest(before, kPlaces)) {
        Sweep fine = sweep;
        fine.begin = before;
        fine.end = touched;
        fine.side = {place - cell, place + cell};
        const float fine_touched = SweptGrid(program, fine).Touch();
        if ((touched - fine_touched) * direction > 0) touched = fine_touched;
      }
      (direction > 0 ? tight.min() : tight.max())[axis] = touched;
    }
  }
  return tight;
}

}  // namespace pickbed::scenes
