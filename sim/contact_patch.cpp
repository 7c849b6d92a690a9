#include "sim/contact_patch.h"

#include <algorithm>
#include <cmath>

namespace pickbed {
namespace {

using Eigen::Vector2d;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Integral of the distance from the origin over the triangle of the origin, a and b: in polar
// coordinates about the foot of the origin on ab, h^3 / 3 times that of sec^3.
double IntegralOfDistance(const Vector2d& a, const Vector2d& b) {
  const double length = (b - a).norm();
  const double h = length > 0 ? Cross(a, b) / length : 0;
  if (!(h > 0)) return 0;
  const Vector2d along = (b - a) / length;
  const auto primitive = [](double t) {  // of sec^3, with t = tan
    return 0.5 * (t * std::sqrt(1 + t * t) + std::asinh(t));
  };
  return h * h * h / 3 * (primitive(b.dot(along) / h) - primitive(a.dot(along) / h));
}

}  // namespace

std::vector<Vector2d> ConvexOutline(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vector2d> hull(2 * points.size());
  size_t n = 0;
  const auto add = [&](const Vector2d& p, size_t least) {
    while (n >= least && Cross(hull[n - 1] - hull[n - 2], p - hull[n - 2]) <= 0) --n;
    hull[n++] = p;
  };
  for (const Vector2d& p : points) add(p, 2);
  const size_t upper = n + 1;
  for (size_t i = points.size() - 1; i-- > 0;) add(points[i], upper);
  hull.resize(n - 1);
  return hull;
}

std::vector<Vector2d> ClippedToRectangle(std::vector<Vector2d> outline, const Vector2d& half) {
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto inside = [&](const Vector2d& p) { return half[axis] - side * p[axis]; };
      std::vector<Vector2d> kept;
      for (size_t i = 0; i < outline.size(); ++i) {
        const Vector2d& a = outline[i];
        const Vector2d& b = outline[(i + 1) % outline.size()];
        const double in_a = inside(a), in_b = inside(b);
        if (in_a >= 0) kept.push_back(a);
        if ((in_a > 0 && in_b < 0) || (in_a < 0 && in_b > 0)) {
          kept.push_back(a + in_a / (in_a - in_b) * (b - a));
        }
      }
      outline = std::move(kept);
    }
  }
  return outline;
}

EvenPressure PressureOn(const std::vector<Vector2d>& outline) {
  const Vector2d& origin = outline.front();
  const size_t count = outline.size();
  double area = 0, span = 0;
  Vector2d moment = Vector2d::Zero(), middle = origin;
  for (size_t i = 0; i < count; ++i) {
    const Vector2d a = outline[i] - origin, b = outline[(i + 1) % count] - origin;
    area += 0.5 * Cross(a, b);
    moment += 0.5 * Cross(a, b) * (a + b) / 3;
    for (const Vector2d& other : outline) {
      if ((outline[i] - other).norm() <= span) continue;
      span = (outline[i] - other).norm();
      middle = 0.5 * (outline[i] + other);
    }
  }
  constexpr double kThin = 1e-3;  // an outline this much narrower than long is a line
  if (area <= kThin * span * span) return {middle, 0.25 * span};
  const Vector2d centroid = origin + moment / area;
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += IntegralOfDistance(outline[i] - centroid, outline[(i + 1) % count] - centroid);
  }
  return {centroid, sum / area};
}

}  // namespace pickbed
