#include "scenes/bin/bin_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "scenes/base/error.h"
#include "scenes/bin/bin_pieces.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxFaces = 50000;
constexpr double kSmallest_m = 0.01, kLargest_m = 10;
constexpr int kLines = 5;  // in each direction
constexpr int kRaysPerLine = 64;
constexpr double kLineShare = 0.5;    // share of the bounds over which the lines are spread
constexpr double kFloorShare = 0.05;  // share of the wall height that still counts as floor
constexpr double kMinStep_m = 0.001;
constexpr double kPrecision_m = 1e-6;

struct Extents {
  double low;
  double high;
};

class Surveyor {
 public:
  Surveyor(const TriangleMesh& mesh, const std::string& source)
      : query_(mesh), bounds_(MeshBounds(mesh)), source_(source) {}

  double FindFloor() {
    std::vector<double> heights;
    int rays = 0;
    for (int i = 0; i < kRaysPerLine; ++i) {
      for (int k = 0; k < kRaysPerLine; ++k, ++rays) {
        const Vector2d share(Fraction(i, kRaysPerLine), Fraction(k, kRaysPerLine));
        const Vector3d p = bounds_.center() + 0.5 * kLineShare * ToXyz(share);
        if (const auto z = Ground(p.x(), p.y())) heights.push_back(*z);
      }
    }
    CheckInput(2 * heights.size() >= static_cast<size_t>(rays),
               fmt::format("{}: the bin has no floor: {:.0f} % of the vertical lines through its "
                           "center pass; close the mesh at the bottom and orient it with z up",
                           source_, 100 - 100.0 * heights.size() / rays));
    std::nth_element(heights.begin(), heights.begin() + heights.size() / 2, heights.end());
    floor_ = heights[heights.size() / 2];
    return floor_;
  }

  // A flat top over a hollow means that the bin is upside down.
  void RequireUpright() const {
    if (bounds_.max.z() - floor_ >= kMinStep_m) return;
    const Vector3d center = bounds_.center();
    const auto hits = query_.AllHits({center.x(), center.y(), Above()}, -Vector3d::UnitZ());
    const bool solid = hits.size() == 2 && hits[1].point.z() < bounds_.min.z() + kMinStep_m;
    const bool thin = bounds_.size().z() < 2 * kMinStep_m;
    const double open_below_m = hits.empty() ? 0 : hits.back().point.z() - bounds_.min.z();
    CheckInput(solid || thin || open_below_m < 0.5 * bounds_.size().z(),
               source_ + ": the bin opens downwards; rotate it so that z is up");
  }

  // Returns the extent along `axis` of the places where the ground is at most at `height_m`. For
  // each line it goes from the first such place to the last. `common` selects the intersection of
  // all lines, else their union.
  Extents Extent(int axis, double height_m, bool common) const {
    std::optional<Extents> all;
    for (int line = 0; line < kLines; ++line) {
      const std::optional<Extents> one = ExtentOfLine(axis, Fraction(line, kLines), height_m);
      if (!one) continue;  // the line runs along a wall between compartments
      if (!all) all = one;
      all->low = common ? std::max(all->low, one->low) : std::min(all->low, one->low);
      all->high = common ? std::min(all->high, one->high) : std::max(all->high, one->high);
    }
    CheckInput(all && all->high > all->low, source_ +
                                                ": the bin's floor is not at its center; close the "
                                                "mesh at the bottom and orient it with z up");
    return *all;
  }

  const Bounds& bounds() const { return bounds_; }
  const MeshQuery& query() const { return query_; }

 private:
  static double Fraction(int i, int count) { return (2.0 * i + 1) / count - 1; }  // -1..1
  Vector3d ToXyz(const Vector2d& share) const {
    return {share.x() * bounds_.size().x(), share.y() * bounds_.size().y(), 0};
  }
  double Above() const { return bounds_.max.z() + 1; }

  // Returns the height of the highest surface at a place, or nullopt if there is none.
  std::optional<double> Ground(double x, double y) const {
    const double reach = bounds_.size().z() + 2;
    const auto hit = query_.Raycast({x, y, Above()}, -Vector3d::UnitZ(), 0, reach);
    return hit ? std::optional(hit->point.z()) : std::nullopt;
  }

  std::optional<Extents> ExtentOfLine(int axis, double line, double height_m) const {
    const int across = 1 - axis;
    Vector3d p = bounds_.center();
    p[across] += 0.5 * kLineShare * line * bounds_.size()[across];
    const auto low_at = [&](double place) {
      p[axis] = place;
      const auto ground = Ground(p.x(), p.y());
      return ground && *ground <= height_m;
    };
    const auto place = [&](int i) {
      return bounds_.center()[axis] + 0.5 * Fraction(i, kRaysPerLine) * bounds_.size()[axis];
    };
    const auto edge = [&](double out, double in) {
      while (std::abs(out - in) > kPrecision_m) {
        const double center = 0.5 * (out + in);
        (low_at(center) ? in : out) = center;
      }
      return in;
    };
    int first = 0, last = kRaysPerLine - 1;
    while (first <= last && !low_at(place(first))) ++first;
    while (last > first && !low_at(place(last))) --last;
    if (first > last) return std::nullopt;
    const double outer = 0.5 * bounds_.size()[axis] + kMinStep_m;
    const double low = first == 0 ? bounds_.center()[axis] - outer : place(first - 1);
    const double high = last == kRaysPerLine - 1 ? bounds_.center()[axis] + outer : place(last + 1);
    return Extents{edge(low, place(first)), edge(high, place(last))};
  }

  MeshQuery query_;
  Bounds bounds_;
  std::string source_;
  double floor_ = 0;
};

}  // namespace

BinShape MakeBinShape(const TriangleMesh& mesh, const std::string& source) {
  RequireUsableMesh(mesh, source);
  CheckInput(mesh.triangles.size() <= kMaxFaces,
             fmt::format("{}: {} faces exceed the limit of {} for a bin; simplify the mesh", source,
                         mesh.triangles.size(), kMaxFaces));
  const int open_edges = InspectMesh(mesh).open_edges;
  CheckInput(open_edges == 0,
             fmt::format("{}: the bin's mesh is open at {} edges; close it and give its walls a "
                         "thickness",
                         source, open_edges));
  BinShape shape;
  shape.mesh_B = TurnedOutwards(mesh);
  Surveyor surveyor(shape.mesh_B, source);
  const double floor = surveyor.FindFloor();
  surveyor.RequireUpright();
  const double height_m = surveyor.bounds().max.z() - floor;
  const bool table = height_m < kMinStep_m;
  const double floor_limit = floor + std::max(kMinStep_m, kFloorShare * height_m);
  const double rim_limit = std::max(floor_limit, surveyor.bounds().max.z() - kMinStep_m);
  Vector3d center(0, 0, floor);
  for (int axis = 0; axis < 2; ++axis) {
    const Extents inside = surveyor.Extent(axis, floor_limit, true);
    const Extents widest = surveyor.Extent(axis, rim_limit, false);
    center[axis] = 0.5 * (inside.low + inside.high);
    shape.inner_size_m[axis] = inside.high - inside.low;
    shape.opening_m[axis] = 2 * std::max(widest.high - center[axis], center[axis] - widest.low);
    shape.wall_m = std::max({shape.wall_m, surveyor.bounds().max[axis] - inside.high,
                             inside.low - surveyor.bounds().min[axis]});
  }
  shape.inner_size_m.z() = table ? 0 : height_m;
  CheckInput(
      shape.inner_size_m.maxCoeff() <= kLargest_m &&
          shape.inner_size_m.head<2>().minCoeff() >= kSmallest_m,
      fmt::format("{}: the bin is {:.3g} x {:.3g} m inside, but the sides must be {} to {} m; "
                  "check bin.unit",
                  source, shape.inner_size_m.x(), shape.inner_size_m.y(), kSmallest_m, kLargest_m));
  shape.wall_m = std::max(shape.wall_m, kMinStep_m);
  shape.mesh_B = Transformed(shape.mesh_B, MakePose(Eigen::Matrix3d::Identity(), -center));
  shape.pieces_B = SolidPieces(shape.mesh_B);
  return shape;
}

BinShape LoadBinShape(const std::filesystem::path& file, const std::string& unit) {
  return MakeBinShape(LoadMesh(file, unit), file.string());
}

}  // namespace pickbed::scenes
