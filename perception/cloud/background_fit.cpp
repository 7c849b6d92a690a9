#include "perception/cloud/background_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>

#include "scenes/base/random.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::perception {
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

// Whether the plane passes through objects, and the surface that they are on is just behind it.
// Many points are just behind such a plane, and they are mixed with the points on it. Around a
// board or a thin floor, the points just behind it are beside it.
bool PassesThroughObjects(const Points& points, const BackgroundPlane& plane, float margin_m) {
  constexpr float kJustBehind = 4;  // margins
  // Share of the points on the plane. Right planes had at most 0.28 in 60 simulated rooms.
  constexpr double kMinJustBehind = 0.4;
  constexpr double kMinMixing = 0.6;  // 1: as at random; 0: no cell has both kinds
  constexpr int kCells = 10;          // per side of a grid over the image region of both kinds
  std::array<std::vector<Eigen::Vector2f>, 2> rays;  // on the plane, just behind it
  Eigen::AlignedBox2f box;
  for (const Eigen::Vector3f& p : points) {
    const float distance = plane.SignedDistance(p), margin = MarginAt(p, margin_m);
    if (distance >= margin || distance <= -kJustBehind * margin) continue;
    rays[distance > -margin ? 0 : 1].emplace_back(p.hnormalized());
    box.extend(p.hnormalized());
  }
  const auto on = static_cast<double>(rays[0].size()), behind = static_cast<double>(rays[1].size());
  if (behind <= kMinJustBehind * on) return false;
  const auto cell_of = [&](float at, float low, float size) {
    const float share = (at - low) / size;  // not a number if the size is 0
    return share < 1 ? static_cast<int>(kCells * share) : kCells - 1;
  };
  std::array<std::array<double, 2>, kCells * kCells> cells{};
  for (const int kind : {0, 1}) {
    for (const Eigen::Vector2f& ray : rays[kind]) {
      const int column = cell_of(ray.x(), box.min().x(), box.sizes().x());
      const int row = cell_of(ray.y(), box.min().y(), box.sizes().y());
      ++cells[row * kCells + column][kind];
    }
  }
  // Each summand is half of the number of points in a cell, times the share of pairs of points with
  // both kinds. If the kinds are mixed at random, this share is the same as for all points.
  double pairs = 0;
  for (const auto& [on_in_cell, behind_in_cell] : cells) {
    const double others = on_in_cell + behind_in_cell - 1;
    if (others > 0) pairs += on_in_cell * behind_in_cell / others;
  }
  return pairs > kMinMixing * on * behind / (on + behind - 1);
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
  const Eigen::Matrix3d covariance = moment / n - mean * mean.transpose();
  const Eigen::Vector3d normal_C = EigenOfSymmetric3(covariance).vectors.col(0);
  return TowardsCamera(normal_C.cast<float>(), mean.cast<float>());
}

// Range between the 5 % and 95 % quantiles.
struct Extent {
  float low = 0, high = 0;
  float length() const { return high - low; }
};
Extent ExtentOf(std::vector<float> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {values[values.size() / 20], values[values.size() - 1 - values.size() / 20]};
}

// Whether the plane is visible across the whole scene, and not only on one object.
bool IsSpread(const Points& points, const BackgroundPlane& plane, float margin_m) {
  constexpr float kMinShare = 0.6f;  // of the extent of all points
  const Eigen::Vector3f along_C = plane.normal_C.unitOrthogonal();
  for (const Eigen::Vector3f& direction_C : {along_C, plane.normal_C.cross(along_C).eval()}) {
    std::vector<float> all, on;
    for (const Eigen::Vector3f& p : points) {
      all.push_back(direction_C.dot(p));
      if (std::abs(plane.SignedDistance(p)) < MarginAt(p, margin_m)) on.push_back(all.back());
    }
    if (ExtentOf(std::move(on)).length() < kMinShare * ExtentOf(std::move(all)).length()) {
      return false;
    }
  }
  return true;
}

// Returns the plane with most points. If it holds too few or passes through objects, returns the
// plane with most points among those with almost nothing behind them. An example is the floor of a
// well filled bin.
std::optional<BackgroundPlane> FitFloor(const Points& points, const BackgroundOptions& options) {
  // 200 draws find a plane with a quarter of the points with probability 1 - (1 - 1/64)^200 = 0.96.
  // The other 200 draws find a small patch of floor: their points are near each other in the input
  // order, which follows the image rows.
  constexpr int kDraws = 400, kNearby = 200;
  constexpr float kMinSine = 1e-3f;  // triangles with a smaller angle span no reliable plane
  constexpr double kMaxBehind = 0.01;
  const int n = static_cast<int>(points.size());
  const float margin_m = static_cast<float>(options.margin_m);
  Rng rng = Rng::Derive(0, 0, "perception/dominant_plane");
  BackgroundPlane largest, last;
  int on_largest = 0, on_last = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const int first = rng.Index(n);
    const auto other = [&] {
      if (draw % 2 == 0) return rng.Index(n);
      return std::clamp(first + rng.Index(2 * kNearby + 1) - kNearby, 0, n - 1);
    };
    const Eigen::Vector3f& a = points[first];
    const Eigen::Vector3f ab = points[other()] - a;
    const Eigen::Vector3f ac = points[other()] - a;
    const Eigen::Vector3f normal = ab.cross(ac);
    if (normal.norm() <= kMinSine * ab.norm() * ac.norm()) continue;
    const BackgroundPlane plane = TowardsCamera(normal.normalized(), a);
    const Sides sides = Count(points, plane, margin_m);
    if (sides.on > on_largest) {
      on_largest = sides.on;
      largest = plane;
    }
    if (sides.on > on_last && sides.behind <= kMaxBehind * n) {
      on_last = sides.on;
      last = plane;
    }
  }
  if (on_largest == 0) return std::nullopt;
  largest = LeastSquares(points, largest, margin_m);
  if (Count(points, largest, margin_m).on >= options.min_plane_share * n &&
      !PassesThroughObjects(points, largest, margin_m)) {
    return largest;
  }
  if (on_last == 0) return std::nullopt;
  last = LeastSquares(points, last, margin_m);
  const Sides sides = Count(points, last, margin_m);
  const bool holds = sides.on >= options.min_hidden_share * n && sides.behind <= kMaxBehind * n;
  return holds && IsSpread(points, last, margin_m) ? std::optional(last) : std::nullopt;
}

// Histogram of points by their coordinate along one direction.
class Profile {
 public:
  Profile(std::vector<float> places_m, float step_m) : step_m_(step_m) {
    const auto [low, high] = std::minmax_element(places_m.begin(), places_m.end());
    low_m_ = *low;
    counts_.assign(static_cast<size_t>((*high - *low) / step_m) + 1, 0);
    for (const float place : places_m) ++counts_[static_cast<size_t>((place - low_m_) / step_m)];
  }

  struct Wall {
    int count = 0;  // points within three steps of it; 0 = no wall
    float place_m = 0;
  };
  // Finds the window of three steps with most points and almost no points further out. Searches
  // from the low end if `near_end`, else from the high end.
  Wall At(bool near_end) const {
    constexpr double kMaxOutside = 0.08;  // share of points on top of the rim
    constexpr int kReach = 1;             // steps to both sides
    const int n = static_cast<int>(counts_.size());
    int all = 0, outside = 0;
    for (const int count : counts_) all += count;
    Wall wall;
    for (int i = 0; i < n; ++i) {
      const int at = near_end ? i : n - 1 - i;
      if (outside > kMaxOutside * all) break;
      int sum = 0;
      for (int k = std::max(0, at - kReach); k <= std::min(n - 1, at + kReach); ++k) {
        sum += counts_[k];
      }
      if (sum > wall.count) wall = {sum, low_m_ + (static_cast<float>(at) + 0.5f) * step_m_};
      outside += counts_[at];
    }
    // Points on objects spread over all steps; the points of a wall concentrate in a few.
    constexpr double kOverMean = 2;
    const double mean = static_cast<double>(all) * (2 * kReach + 1) / n;
    return wall.count >= kOverMean * mean ? wall : Wall();
  }

 private:
  float step_m_, low_m_ = 0;
  std::vector<int> counts_;
};

// Share of the cells of a grid over both extents that hold a point. A wall fills most of the grid;
// objects do not, because only some of them reach as high as others.
double Filled(const std::vector<float>& along, const std::vector<float>& up) {
  constexpr int kColumns = 8, kRows = 3;
  const Extent x = ExtentOf(along), y = ExtentOf(up);
  std::array<bool, kColumns * kRows> filled{};
  for (size_t i = 0; i < along.size(); ++i) {
    const float u = (along[i] - x.low) / x.length(), v = (up[i] - y.low) / y.length();
    if (!(u >= 0 && u < 1 && v >= 0 && v < 1)) continue;
    filled[static_cast<int>(v * kRows) * kColumns + static_cast<int>(u * kColumns)] = true;
  }
  return static_cast<double>(std::count(filled.begin(), filled.end(), true)) / filled.size();
}

struct Rectangle {
  std::vector<BackgroundPlane> walls;
  int seen_from_within = 0;  // walls whose inner side faces the camera
  int count = 0;             // points at the walls
};

// Finds walls at right angles to each other, with the first axis rotated by `angle` (rad) about the
// floor normal.
Rectangle WallsAt(const Points& over_floor, const std::vector<float>& heights_m,
                  const Eigen::Vector3f& along_C, const Eigen::Vector3f& across_C, float angle,
                  float step_m) {
  // Minimum extent of a wall's points, as shares of the length of its side and of the height.
  // Points on one object are close together, and points on the edges of equal objects have one
  // height.
  constexpr float kMinLength = 0.5f, kMinHeight = 0.25f;
  constexpr double kMinFilled = 0.6;
  const float height_m = ExtentOf(heights_m).high;
  const std::array<Eigen::Vector3f, 2> directions_C = {
      std::cos(angle) * along_C + std::sin(angle) * across_C,
      std::cos(angle) * across_C - std::sin(angle) * along_C};
  std::array<std::vector<float>, 2> places_m;
  for (const Eigen::Vector3f& p : over_floor) {
    for (const int k : {0, 1}) places_m[k].push_back(directions_C[k].dot(p));
  }
  Rectangle found;
  for (const int k : {0, 1}) {
    const Eigen::Vector3f& direction_C = directions_C[k];
    const std::vector<float>& beside_m = places_m[1 - k];
    const Profile profile(places_m[k], step_m);
    for (const bool near_end : {true, false}) {
      const Profile::Wall wall = profile.At(near_end);
      if (wall.count == 0) continue;
      std::vector<float> along_m, up_m;  // of the wall's points
      for (size_t i = 0; i < beside_m.size(); ++i) {
        if (std::abs(places_m[k][i] - wall.place_m) > 1.5f * step_m) continue;
        along_m.push_back(beside_m[i]);
        up_m.push_back(heights_m[i]);
      }
      if (ExtentOf(along_m).length() < kMinLength * ExtentOf(beside_m).length() ||
          ExtentOf(up_m).length() < kMinHeight * height_m || Filled(along_m, up_m) < kMinFilled) {
        continue;
      }
      const float inwards = near_end ? 1.0f : -1.0f;
      found.walls.push_back({inwards * direction_C, inwards * wall.place_m});
      found.seen_from_within += inwards * wall.place_m < 0;  // the camera is at the origin
      found.count += wall.count;
    }
  }
  return found;
}

// Refits the wall to its points by least squares and keeps it upright. Returns the input wall if
// the refit rotates it by more than 10 degrees.
BackgroundPlane Refitted(const Points& over_floor, const BackgroundPlane& floor,
                         const BackgroundPlane& wall, float margin_m) {
  constexpr float kMinCos = 0.985f;  // cosine of 10 degrees
  const Eigen::Vector3f fitted = LeastSquares(over_floor, wall, margin_m).normal_C;
  Eigen::Vector3f upright = fitted - floor.normal_C.dot(fitted) * floor.normal_C;
  if (upright.norm() < kMinCos) return wall;
  upright.normalize();
  const float cosine = upright.dot(wall.normal_C);
  if (std::abs(cosine) < kMinCos) return wall;
  if (cosine < 0) upright = -upright;
  double sum_m = 0;
  int n = 0;
  for (const Eigen::Vector3f& p : over_floor) {
    if (std::abs(wall.SignedDistance(p)) >= MarginAt(p, margin_m)) continue;
    sum_m += upright.dot(p);
    ++n;
  }
  return n > 0 ? BackgroundPlane{upright, static_cast<float>(sum_m / n)} : wall;
}

// Finds the floor of a bin that rests on a table. It exists if almost no point inside the walls is
// on the table; it is then the lowest level with many points.
std::optional<BackgroundPlane> InnerFloor(const Points& points, const BackgroundPlane& table,
                                          const std::vector<BackgroundPlane>& walls,
                                          float margin_m) {
  constexpr double kMaxTable = 0.03;
  std::vector<float> heights_m, depths_m;
  int on_table = 0;
  for (const Eigen::Vector3f& p : points) {
    const bool inside = std::all_of(walls.begin(), walls.end(), [&](const BackgroundPlane& wall) {
      return wall.SignedDistance(p) > MarginAt(p, margin_m);
    });
    if (!inside) continue;
    const float height_m = table.SignedDistance(p);
    if (height_m <= MarginAt(p, margin_m)) {
      ++on_table;
    } else {
      heights_m.push_back(height_m);
      depths_m.push_back(p.z());
    }
  }
  const double inside = static_cast<double>(heights_m.size()) + on_table;
  if (heights_m.empty() || on_table > kMaxTable * inside) return std::nullopt;
  const Extent depth = ExtentOf(std::move(depths_m));
  const Profile profile(std::move(heights_m), margin_m * depth.high * depth.high);
  const Profile::Wall floor = profile.At(true);
  if (floor.count == 0) return std::nullopt;
  return BackgroundPlane{table.normal_C, table.offset_m + floor.place_m};
}

std::vector<BackgroundPlane> FitWalls(const Points& points, const BackgroundPlane& floor,
                                      const BackgroundOptions& options) {
  constexpr int kAngles = 180;  // steps of half a degree over 90 degrees
  constexpr size_t kMinPoints = 100;
  constexpr int kMinWithin = 3;  // walls seen from inside; the sides of an object are not
  const float margin_m = static_cast<float>(options.margin_m);
  constexpr float kMaxSteps = 2000;  // no work cell is larger: the depth unit must be wrong
  Points over_floor;
  std::vector<float> depths_m, heights_m;
  for (const Eigen::Vector3f& p : points) {
    if (floor.SignedDistance(p) <= MarginAt(p, margin_m)) continue;
    over_floor.push_back(p);
    depths_m.push_back(p.z());
    heights_m.push_back(floor.SignedDistance(p));
  }
  if (over_floor.size() < kMinPoints) return {};
  std::nth_element(depths_m.begin(), depths_m.begin() + depths_m.size() / 2, depths_m.end());
  const float z_m = depths_m[depths_m.size() / 2];
  const float step_m = margin_m * z_m * z_m;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : over_floor) box.extend(p);
  if (!(box.diagonal().norm() < kMaxSteps * step_m)) return {};
  const Eigen::Vector3f along_C = floor.normal_C.unitOrthogonal();
  const Eigen::Vector3f across_C = floor.normal_C.cross(along_C);
  Rectangle best;
  for (int i = 0; i < kAngles; ++i) {
    const float angle = std::numbers::pi_v<float> / 2 * static_cast<float>(i) / kAngles;
    Rectangle found = WallsAt(over_floor, heights_m, along_C, across_C, angle, step_m);
    if (found.seen_from_within >= kMinWithin && found.count > best.count) best = std::move(found);
  }
  for (BackgroundPlane& wall : best.walls) wall = Refitted(over_floor, floor, wall, 2 * margin_m);
  return best.walls;
}

}  // namespace

void BackgroundOptions::Visit(SettingsVisitor& v) {
  v.Real("margin_m", margin_m, {0, 1}, "distance at which a point is on a plane, m, at 1 m");
  v.Real("min_plane_share", min_plane_share, {0, 1},
         "minimum share of all points on the table or floor");
  v.Real("min_hidden_share", min_hidden_share, {0, 1},
         "minimum share of all points on a plane that has almost no points behind it");
}

std::vector<BackgroundPlane> FitBackground(const Points& points_C,
                                           const BackgroundOptions& options) {
  CheckSettings("BackgroundOptions", options);
  const auto is_finite = [](const Eigen::Vector3f& p) { return p.allFinite(); };
  if (!std::all_of(points_C.begin(), points_C.end(), is_finite)) {
    Points finite_C;
    std::copy_if(points_C.begin(), points_C.end(), std::back_inserter(finite_C), is_finite);
    return FitBackground(finite_C, options);
  }
  if (points_C.size() < 3) return {};
  const std::optional<BackgroundPlane> floor = FitFloor(points_C, options);
  if (!floor) return {};
  std::vector<BackgroundPlane> planes = FitWalls(points_C, *floor, options);
  if (!planes.empty()) {
    const float margin_m = static_cast<float>(options.margin_m);
    const auto inner = InnerFloor(points_C, *floor, planes, margin_m);
    if (inner) planes.push_back(*inner);
  }
  planes.push_back(*floor);
  return planes;
}

}  // namespace pickbed::perception
