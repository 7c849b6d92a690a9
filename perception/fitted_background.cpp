#include "perception/fitted_background.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "scenes/random.h"

namespace pickbed {
namespace {

using Points = std::vector<Eigen::Vector3f>;

float MarginAt(const Eigen::Vector3f& p, float margin_m) { return margin_m * p.z() * p.z(); }

BackgroundPlane TowardsCamera(const Eigen::Vector3f& normal_C, const Eigen::Vector3f& point_C) {
  const float sign = normal_C.dot(point_C) > 0 ? -1.0f : 1.0f;  // the camera is at the origin
  return {sign * normal_C, sign * normal_C.dot(point_C)};
}

struct Sides {
  int on = 0, behind = 0;
};

Sides Count(const Points& points, const BackgroundPlane& plane, float margin_m) {
  Sides sides;
  for (const Eigen::Vector3f& p : points) {
    const float distance = plane.SignedDistance(p), margin = MarginAt(p, margin_m);
    sides.on += std::abs(distance) < margin;
    sides.behind += distance <= -margin;
  }
  return sides;
}

BackgroundPlane LeastSquares(const Points& points, const BackgroundPlane& start, float margin_m) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  int n = 0;
  for (const Eigen::Vector3f& p : points) {
    if (std::abs(start.SignedDistance(p)) >= MarginAt(p, margin_m)) continue;
    const Eigen::Vector3d d = p.cast<double>();
    sum += d;
    moment += d * d.transpose();
    ++n;
  }
  if (n < 3) return start;
  const Eigen::Vector3d mean = sum / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment / n - mean * mean.transpose());
  return TowardsCamera(solver.eigenvectors().col(0).cast<float>(), mean.cast<float>());
}

// The plane of most points; where that holds too few, the one of most points among those with next
// to nothing behind them, as the floor of a well filled bin.
std::optional<BackgroundPlane> FitFloor(const Points& points, const BackgroundOptions& options) {
  // 200 draws find a plane of a quarter of the points with probability 1 - (1 - 1/64)^200 = 0.96.
  constexpr int kDraws = 200;
  constexpr float kMinSine = 1e-3f;  // of a triangle that spans a plane
  constexpr double kMostBehind = 0.01;
  const int n = static_cast<int>(points.size());
  const float margin_m = static_cast<float>(options.margin_m);
  Rng rng = Rng::Derive(0, 0, "perception/dominant_plane");
  BackgroundPlane largest, last;
  int on_largest = 0, on_last = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Eigen::Vector3f& a = points[rng.Index(n)];
    const Eigen::Vector3f ab = points[rng.Index(n)] - a;
    const Eigen::Vector3f ac = points[rng.Index(n)] - a;
    const Eigen::Vector3f normal = ab.cross(ac);
    if (normal.norm() <= kMinSine * ab.norm() * ac.norm()) continue;
    const BackgroundPlane plane = TowardsCamera(normal.normalized(), a);
    const Sides sides = Count(points, plane, margin_m);
    if (sides.on > on_largest) {
      on_largest = sides.on;
      largest = plane;
    }
    if (sides.on > on_last && sides.behind <= kMostBehind * n) {
      on_last = sides.on;
      last = plane;
    }
  }
  if (on_largest == 0) return std::nullopt;
  largest = LeastSquares(points, largest, margin_m);
  if (Count(points, largest, margin_m).on >= options.min_plane_share * n) return largest;
  last = LeastSquares(points, last, margin_m);
  const Sides sides = Count(points, last, margin_m);
  const bool holds = sides.on >= options.min_hidden_share * n && sides.behind <= kMostBehind * n;
  return holds ? std::optional(last) : std::nullopt;
}

// Points over the floor by their place along one direction of it.
class Profile {
 public:
  Profile(std::vector<float> places_m, float step_m) : step_m_(step_m) {
    const auto [low, high] = std::minmax_element(places_m.begin(), places_m.end());
    low_m_ = *low;
    counts_.assign(static_cast<size_t>((*high - *low) / step_m) + 1, 0);
    for (const float place : places_m) ++counts_[static_cast<size_t>((place - low_m_) / step_m)];
  }

  struct Wall {
    int count = 0;  // points over its line; 0 = there is none
    float place_m = 0;
  };
  // The most points within three steps with next to nothing further out, at the far end or, for
  // `near_end`, at the other.
  Wall At(bool near_end) const {
    constexpr double kMostOutside = 0.08;  // the rim's top
    constexpr int kReach = 1;              // steps to both sides
    const int n = static_cast<int>(counts_.size());
    int all = 0, outside = 0;
    for (const int count : counts_) all += count;
    Wall wall;
    for (int i = 0; i < n; ++i) {
      const int at = near_end ? i : n - 1 - i;
      if (outside > kMostOutside * all) break;
      int sum = 0;
      for (int k = std::max(0, at - kReach); k <= std::min(n - 1, at + kReach); ++k) {
        sum += counts_[k];
      }
      if (sum > wall.count) wall = {sum, low_m_ + (static_cast<float>(at) + 0.5f) * step_m_};
      outside += counts_[at];
    }
    // Points of parts are everywhere; a wall's stand together.
    constexpr double kOverMean = 2;
    const double mean = static_cast<double>(all) * (2 * kReach + 1) / n;
    return wall.count >= kOverMean * mean ? wall : Wall();
  }

 private:
  float step_m_, low_m_ = 0;
  std::vector<int> counts_;
};

struct Rectangle {
  std::vector<BackgroundPlane> walls;
  int seen_from_within = 0;
  int count = 0;  // points at the walls
};

// The walls at right angles to each other, the first turned by `angle` about the floor's normal.
Rectangle WallsAt(const Points& over_floor, const Eigen::Vector3f& along_C,
                  const Eigen::Vector3f& across_C, float angle, float step_m) {
  Rectangle found;
  for (const float turn : {0.0f, std::numbers::pi_v<float> / 2}) {
    const Eigen::Vector3f direction_C =
        std::cos(angle + turn) * along_C + std::sin(angle + turn) * across_C;
    std::vector<float> places_m;
    for (const Eigen::Vector3f& p : over_floor) places_m.push_back(direction_C.dot(p));
    const Profile profile(std::move(places_m), step_m);
    for (const bool near_end : {true, false}) {
      const Profile::Wall wall = profile.At(near_end);
      if (wall.count == 0) continue;
      const float inwards = near_end ? 1.0f : -1.0f;
      found.walls.push_back({inwards * direction_C, inwards * wall.place_m});
      found.seen_from_within += inwards * wall.place_m < 0;  // the camera is at the origin
      found.count += wall.count;
    }
  }
  return found;
}

std::vector<BackgroundPlane> FitWalls(const Points& points, const BackgroundPlane& floor,
                                      const BackgroundOptions& options) {
  constexpr int kAngles = 180;  // half degrees of a quarter turn
  constexpr size_t kLeastPoints = 100;
  constexpr int kLeastWithin = 3;  // walls that show their inner side, which a part's do not
  const float margin_m = static_cast<float>(options.margin_m);
  Points over_floor;
  double z_sum_m = 0;
  for (const Eigen::Vector3f& p : points) {
    if (floor.SignedDistance(p) <= MarginAt(p, margin_m)) continue;
    over_floor.push_back(p);
    z_sum_m += p.z();
  }
  if (over_floor.size() < kLeastPoints) return {};
  const double z_m = z_sum_m / static_cast<double>(over_floor.size());
  const float step_m = static_cast<float>(options.margin_m * z_m * z_m);
  const Eigen::Vector3f along_C = floor.normal_C.unitOrthogonal();
  const Eigen::Vector3f across_C = floor.normal_C.cross(along_C);
  Rectangle best;
  for (int i = 0; i < kAngles; ++i) {
    const float angle = std::numbers::pi_v<float> / 2 * static_cast<float>(i) / kAngles;
    Rectangle found = WallsAt(over_floor, along_C, across_C, angle, step_m);
    if (found.seen_from_within >= kLeastWithin && found.count > best.count) best = std::move(found);
  }
  for (BackgroundPlane& wall : best.walls) {
    const BackgroundPlane fitted = LeastSquares(over_floor, wall, 2 * margin_m);
    const float sign = fitted.normal_C.dot(wall.normal_C) < 0 ? -1.0f : 1.0f;
    wall = {sign * fitted.normal_C, sign * fitted.offset_m};
  }
  return best.walls;
}

}  // namespace

std::vector<BackgroundPlane> FitBackground(const Points& points_C,
                                           const BackgroundOptions& options) {
  if (points_C.size() < 3) return {};
  const std::optional<BackgroundPlane> floor = FitFloor(points_C, options);
  if (!floor) return {};
  std::vector<BackgroundPlane> planes = FitWalls(points_C, *floor, options);
  planes.push_back(*floor);
  return planes;
}

}  // namespace pickbed
