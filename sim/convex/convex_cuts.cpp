#include "sim/convex/convex_cuts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "scenes/base/error.h"
#include "scenes/geometry/sphere_directions.h"
#include "sim/convex/convex_hull.h"
#include "sim/convex/solid_columns.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;  // convex and planar

constexpr int kColumns = 64;        // columns of SolidColumns, for the solid's volume
constexpr double kSnap = 1e-7;      // share of the mesh size; a nearer point is on the plane
constexpr double kThinnest = 0.02;  // minimum distance of a cut to a piece's ends, share of extent
constexpr double kFlat = 0.9995;    // smallest |cosine| of a face perpendicular to an axis
constexpr double kCenterPreference = 1e-3;  // penalty of a cut at an end, share of hull volume
constexpr double kLittleGain = 0.1;    // share of a piece's air; a cut that saves less looks ahead
constexpr int kSpreadDirections = 40;  // in addition to the 26 of a cube

// Returns the directions of the support points: the 26 of a cube's faces, edges and corners, and
// some evenly spread ones. The cube's directions make boxes exact.
std::vector<Vector3d> MakeDirections() {
  std::vector<Vector3d> directions;
  for (int i = 0; i < 27; ++i) {
    const Vector3d d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (i != 13) directions.push_back(d.normalized());
  }
  const std::vector<Vector3d> spread = SphereDirections(kSpreadDirections);
  directions.insert(directions.end(), spread.begin(), spread.end());
  return directions;
}

// The support point of a point set in each direction.
class Extremes {
 public:
  explicit Extremes(const std::vector<Vector3d>& directions)
      : directions_(directions),
        reach_(directions.size(), -std::numeric_limits<double>::infinity()),
        points_(directions.size()) {}

  void Add(const Vector3d& p) {
    for (size_t i = 0; i < directions_.size(); ++i) {
      const double reach = directions_[i].dot(p);
      if (reach > reach_[i]) {
        reach_[i] = reach;
        points_[i] = p;
      }
    }
  }
  void Add(const Extremes& other) {
    for (size_t i = 0; i < directions_.size(); ++i) {
      if (other.reach_[i] > reach_[i]) {
        reach_[i] = other.reach_[i];
        points_[i] = other.points_[i];
      }
    }
  }
  bool empty() const { return !std::isfinite(reach_[0]); }
  double HullVolume() const { return empty() ? 0 : MakeConvexHull(points_).Volume(); }

 private:
  const std::vector<Vector3d>& directions_;
  std::vector<double> reach_;
  std::vector<Vector3d> points_;
};

// Splits a convex polygon by a plane. A polygon inside the plane goes to the side of its solid,
// which is behind it.
std::pair<Polygon, Polygon> Split(const Polygon& polygon, int axis, double offset, double snap) {
  Polygon below, above;
  bool any_below = false, any_above = false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& p = polygon[i];
    const Vector3d& q = polygon[(i + 1) % polygon.size()];
    const auto side = [&](const Vector3d& x) {
      const double d = x[axis] - offset;
      return std::abs(d) <= snap ? 0.0 : d;
    };
    const double dp = side(p), dq = side(q);
    if (dp <= 0) below.push_back(p);
    if (dp >= 0) above.push_back(p);
    any_below |= dp < 0;
    any_above |= dp > 0;
    if (dp * dq < 0) {
      Vector3d cut = p + dp / (dp - dq) * (q - p);
      cut[axis] = offset;
      below.push_back(cut);
      above.push_back(cut);
    }
  }
  if (!any_below && !any_above) {
    const double normal = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0])[axis];
    (normal > 0 ? above : below).clear();
    return {below, above};
  }
  if (!any_below) below.clear();
  if (!any_above) above.clear();
  return {below, above};
}

struct Cut {
  int axis = -1;  // -1 = no cut
  double offset = 0;
};

struct Piece {
  Eigen::AlignedBox3d box;
  std::array<std::array<bool, 2>, 3> is_cut{};  // which box sides are cuts: [axis][high]
  std::vector<Polygon> polygons;
  double air_m3 = 0;
  Cut best;
  double hull_m3 = 0, halves_m3 = 0;  // hull volumes: of the piece, and summed over both halves
};

class Cutter {
 public:
  Cutter(const TriangleMesh& mesh, const PlaneCutOptions& options)
      : mesh_(mesh), options_(options), columns_(mesh, kColumns) {
    snap_ = kSnap * MeshBounds(mesh).size().maxCoeff();
  }
  std::vector<std::vector<Vector3d>> Run();

 private:
  Piece Whole() const;
  void Judge(Piece& piece) const;
  void LookAhead(Piece& piece) const;
  std::pair<Piece, Piece> Apply(const Piece& piece) const;
  std::vector<double> Candidates(const Piece& piece, int axis) const;
  std::vector<Extremes> Slabs(const Piece& piece, int axis,
                              const std::vector<double>& offsets) const;
  std::vector<Vector3d> Points(const Piece& piece) const;

  const TriangleMesh& mesh_;
  const PlaneCutOptions& options_;
  const SolidColumns columns_;
  const std::vector<Vector3d> directions_ = MakeDirections();
  double snap_ = 0;
};

Eigen::AlignedBox3d BoxOf(const std::vector<Polygon>& polygons) {
  Eigen::AlignedBox3d box;
  for (const Polygon& polygon : polygons) {
    for (const Vector3d& p : polygon) box.extend(p);
  }
  return box;
}

Piece Cutter::Whole() const {
  Piece whole;
  for (const Eigen::Vector3i& t : mesh_.triangles) {
    whole.polygons.push_back({mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]});
  }
  whole.box = BoxOf(whole.polygons);
  return whole;
}

// Returns candidate offsets of planes perpendicular to `axis`, ascending.
std::vector<double> Cutter::Candidates(const Piece& piece, int axis) const {
  const Eigen::AlignedBox3d extent = BoxOf(piece.polygons);
  const double low = extent.min()[axis], size = extent.sizes()[axis];
  std::vector<double> offsets;
  for (int i = 1; i <= options_.uniform_planes; ++i) {
    offsets.push_back(low + size * i / (options_.uniform_planes + 1));
  }
  // From the coordinate in steps of 10 snap_ to (area, coordinate).
  std::map<long, std::pair<double, double>> flats;
  for (const Polygon& polygon : piece.polygons) {
    Vector3d normal = Vector3d::Zero();
    for (size_t i = 2; i < polygon.size(); ++i) {
      normal += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
    }
    if (std::abs(normal[axis]) < kFlat * normal.norm()) continue;
    auto& [area, coordinate] = flats[std::lround(polygon[0][axis] / (10 * snap_))];
    area += normal.norm();
    coordinate = polygon[0][axis];
  }
  std::vector<std::pair<double, double>> by_area;
  for (const auto& [key, flat] : flats) by_area.push_back(flat);
  std::stable_sort(by_area.begin(), by_area.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  int taken = 0;
  for (const auto& [area, coordinate] : by_area) {
    const double share = (coordinate - low) / size;
    if (share < kThinnest || share > 1 - kThinnest) continue;
    if (taken++ == options_.face_planes) break;
    offsets.push_back(coordinate);
  }
  std::sort(offsets.begin(), offsets.end());
  offsets.erase(std::unique(offsets.begin(), offsets.end(),
                            [&](double a, double b) { return b - a < 20 * snap_; }),
                offsets.end());
  return offsets;
}

// Returns the support points of each slab between neighboring planes: offsets.size() + 1 slabs.
std::vector<Extremes> Cutter::Slabs(const Piece& piece, int axis,
                                    const std::vector<double>& offsets) const {
  std::vector<Extremes> slabs(offsets.size() + 1, Extremes(directions_));
  for (const Polygon& polygon : piece.polygons) {
    double low = polygon[0][axis], high = low;
    for (const Vector3d& p : polygon) {
      low = std::min(low, p[axis]);
      high = std::max(high, p[axis]);
    }
    size_t k = std::lower_bound(offsets.begin(), offsets.end(), low - snap_) - offsets.begin();
    Polygon rest;
    const Polygon* current = &polygon;
    for (; k < offsets.size() && high >= offsets[k] - snap_; ++k) {
      auto [below, above] = Split(*current, axis, offsets[k], snap_);
      for (const Vector3d& p : below) slabs[k].Add(p);
      rest = std::move(above);
      current = &rest;
      if (rest.empty()) break;
    }
    for (const Vector3d& p : *current) slabs[k].Add(p);
  }
  return slabs;
}

// Computes the air in the piece's hull, and the cut with the smallest sum of hull volumes.
void Cutter::Judge(Piece& piece) const {
  Extremes all(directions_);
  double minimum = std::numeric_limits<double>::infinity();
  double hull_m3 = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> offsets = Candidates(piece, axis);
    const std::vector<Extremes> slabs = Slabs(piece, axis, offsets);
    std::vector<double> above_m3(slabs.size());
    Extremes merged(directions_);
    for (size_t k = slabs.size(); k-- > 0;) {
      merged.Add(slabs[k]);
      if (k > 0 || axis == 0) above_m3[k] = merged.HullVolume();
    }
    if (axis == 0) hull_m3 = above_m3[0];
    const Eigen::AlignedBox3d extent = BoxOf(piece.polygons);
    Extremes below(directions_);
    for (size_t k = 0; k < offsets.size(); ++k) {
      below.Add(slabs[k]);
      const double off_center =
          std::abs(offsets[k] - extent.center()[axis]) / extent.sizes().maxCoeff();
      const double sum =
          below.HullVolume() + above_m3[k + 1] + kCenterPreference * hull_m3 * off_center;
      if (sum >= minimum) continue;
      minimum = sum;
      piece.best = {axis, offsets[k]};
      piece.halves_m3 = below.HullVolume() + above_m3[k + 1];
    }
  }
  piece.hull_m3 = hull_m3;
  piece.air_m3 = hull_m3 - columns_.VolumeIn(piece.box);
}

// A single cut of a tube saves no air in any direction, because the hulls of both halves still span
// the bore. Only the second cut across the bore does. So this takes the center cut whose halves
// have the best cuts of their own.
void Cutter::LookAhead(Piece& piece) const {
  const Eigen::AlignedBox3d extent = BoxOf(piece.polygons);
  double minimum = std::numeric_limits<double>::infinity();
  Cut best = piece.best;
  for (int axis = 0; axis < 3; ++axis) {
    piece.best = {axis, extent.center()[axis]};
    auto [low, high] = Apply(piece);
    if (low.polygons.empty() || high.polygons.empty()) continue;
    Judge(low);
    Judge(high);
    const double quarters_m3 = low.halves_m3 + high.halves_m3;
    if (quarters_m3 >= minimum) continue;
    minimum = quarters_m3;
    best = {axis, extent.center()[axis]};
  }
  piece.best = best;
}

std::pair<Piece, Piece> Cutter::Apply(const Piece& piece) const {
  const auto [axis, offset] = piece.best;
  Piece low, high;
  low.box = high.box = piece.box;
  low.is_cut = high.is_cut = piece.is_cut;
  low.box.max()[axis] = high.box.min()[axis] = offset;
  low.is_cut[axis][1] = high.is_cut[axis][0] = true;
  for (const Polygon& polygon : piece.polygons) {
    auto [below, above] = Split(polygon, axis, offset, snap_);
    if (!below.empty()) low.polygons.push_back(std::move(below));
    if (!above.empty()) high.polygons.push_back(std::move(above));
  }
  return {std::move(low), std::move(high)};
}

// Returns the surface's points, and the corners of the box that are inside the solid and bounded by
// three cuts.
std::vector<Vector3d> Cutter::Points(const Piece& piece) const {
  std::vector<Vector3d> points;
  for (const Polygon& polygon : piece.polygons) {
    points.insert(points.end(), polygon.begin(), polygon.end());
  }
  for (int i = 0; i < 8; ++i) {
    const std::array<int, 3> high{i & 1, i >> 1 & 1, i >> 2 & 1};
    Vector3d corner;
    bool all_cuts = true;
    for (int axis = 0; axis < 3; ++axis) {
      corner[axis] = high[axis] ? piece.box.max()[axis] : piece.box.min()[axis];
      all_cuts &= piece.is_cut[axis][high[axis]];
    }
    // The probe is a little nearer to the center, because cuts coincide with faces of the mesh.
    const Vector3d probe = corner + 1e-4 * (piece.box.center() - corner);
    if (all_cuts && IsInside(mesh_, probe)) points.push_back(corner);
  }
  return points;
}

std::vector<std::vector<Vector3d>> Cutter::Run() {
  std::vector<Piece> pieces{Whole()};
  const double enough_m3 = options_.max_air_share * std::max(0.0, columns_.VolumeIn(pieces[0].box));
  Judge(pieces[0]);
  if (!(pieces[0].hull_m3 > 0)) return {};
  while (static_cast<int>(pieces.size()) < options_.max_pieces) {
    const auto worst =
        std::max_element(pieces.begin(), pieces.end(),
                         [](const Piece& a, const Piece& b) { return a.air_m3 < b.air_m3; });
    if (worst->air_m3 <= enough_m3 || worst->best.axis < 0) break;
    if (worst->hull_m3 - worst->halves_m3 < kLittleGain * worst->air_m3) LookAhead(*worst);
    auto [low, high] = Apply(*worst);
    if (low.polygons.empty() || high.polygons.empty()) break;
    Judge(low);
    Judge(high);
    *worst = std::move(low);
    pieces.push_back(std::move(high));
  }
  std::vector<std::vector<Vector3d>> points;
  for (const Piece& piece : pieces) points.push_back(Points(piece));
  return points;
}

}  // namespace

std::vector<std::vector<Vector3d>> CutByPlanes(const TriangleMesh& mesh,
                                               const PlaneCutOptions& options) {
  CheckInput(std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                         [](const Vector3d& p) { return p.allFinite(); }),
             "a vertex of the mesh is not finite; repair the mesh");
  if (!(MeshBounds(mesh).size().array() > 0).all()) return {};
  return Cutter(mesh, options).Run();
}

}  // namespace pickbed::sim
