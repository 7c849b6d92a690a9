#include "grasp/cloud/cloud_suction.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "grasp/plan/clearance.h"
#include "scenes/base/error.h"
#include "scenes/base/math.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// Points of the surface by cells of the floor plan.
class PointGrid {
 public:
  PointGrid(const std::vector<SurfacePoint>& points, double cell_m)
      : points_(points), cell_m_(cell_m) {
    Eigen::Array2d high = Eigen::Array2d::Constant(-std::numeric_limits<double>::infinity());
    low_ = -high;
    for (const SurfacePoint& point : points) {
      low_ = low_.min(point.p_B.head<2>().cast<double>().array());
      high = high.max(point.p_B.head<2>().cast<double>().array());
    }
    if (points.empty()) return;
    columns_ = static_cast<int>((high.x() - low_.x()) / cell_m) + 1;
    rows_ = static_cast<int>((high.y() - low_.y()) / cell_m) + 1;
    cells_.resize(static_cast<size_t>(columns_) * rows_);
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Array2i cell = CellOf(points[i].p_B.cast<double>());
      cells_[static_cast<size_t>(cell.y()) * columns_ + cell.x()].push_back(static_cast<int>(i));
    }
  }

  // Calls `visit(point)` for each point within `radius_m` of `p_B`.
  template <typename Visit>
  void ForEachNear(const Vector3d& p_B, double radius_m, const Visit& visit) const {
    const Vector3d reach(radius_m, radius_m, 0);
    const Eigen::Array2i first = CellOf(p_B - reach).max(0);
    const Eigen::Array2i last = CellOf(p_B + reach).min(Eigen::Array2i(columns_ - 1, rows_ - 1));
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        for (const int i : cells_[static_cast<size_t>(y) * columns_ + x]) {
          const SurfacePoint& point = points_[i];
          if ((point.p_B.cast<double>() - p_B).norm() <= radius_m) visit(point);
        }
      }
    }
  }

 private:
  Eigen::Array2i CellOf(const Vector3d& p_B) const {
    return ((p_B.head<2>().array() - low_) / cell_m_).floor().cast<int>();
  }

  const std::vector<SurfacePoint>& points_;
  const double cell_m_;
  Eigen::Array2d low_;
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<int>> cells_;
};

struct Plane {
  Vector3d center = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();  // upwards
};

Plane PlaneOf(const std::vector<Vector3d>& points) {
  Plane plane;
  for (const Vector3d& p : points) plane.center += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) {
    spread += (p - plane.center) * (p - plane.center).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  plane.normal = solver.eigenvectors().col(0);
  if (plane.normal.z() < 0) plane.normal = -plane.normal;
  return plane;
}

Pose LipPose(const Vector3d& p_B, const Vector3d& normal_B, double press_m) {
  Eigen::Matrix3d R_BG;
  R_BG.col(2) = -normal_B;
  R_BG.col(0) = normal_B.unitOrthogonal();
  R_BG.col(1) = R_BG.col(2).cross(R_BG.col(0));
  return MakePose(R_BG, p_B - press_m * normal_B);
}

// The parts of one image that all cups share.
struct SeenSurface {
  const ObservedSurface& surface;
  const PointGrid& grid;
  double bottom_m, top_m;  // range of the tops of the segments
};

// Tests whether a cup seals on a place of the surface. Adds the cause to `rejected` if not.
std::optional<Grasp> GraspAt(const SeenSurface& seen, const SurfacePoint& place,
                             const SuctionCup& gripper, double max_tilt_rad,
                             const CloudSuctionOptions& options,
                             std::map<std::string, int>& rejected) {
  const CupSpec& cup = gripper.cup;
  const Vector3d p_B = place.p_B.cast<double>();
  std::vector<Vector3d> under;
  bool has_edge = false;
  seen.grid.ForEachNear(p_B, options.rim_outside * cup.radius_m, [&](const SurfacePoint& point) {
    if (point.segment == place.segment) {
      under.push_back(point.p_B.cast<double>());
    } else if ((point.p_B - place.p_B).norm() < cup.radius_m) {
      has_edge = true;
    }
  });
  if (has_edge || under.size() < 3) {
    ++rejected["lip over an edge"];
    return std::nullopt;
  }
  const Plane plane = PlaneOf(under);
  const double tilt_rad = std::acos(std::clamp(plane.normal.z(), -1.0, 1.0));
  if (tilt_rad > max_tilt_rad) {
    ++rejected["tilt"];
    return std::nullopt;
  }
  const Vector3d on_plane = p_B - plane.normal * plane.normal.dot(p_B - plane.center);
  const Pose X_BG = LipPose(on_plane, plane.normal, cup.press_m);
  std::vector<uint8_t> has_surface(options.rim_sectors, 0);
  int even = 0;
  double sum_m2 = 0;
  for (const Vector3d& p : under) {
    const double off_m = plane.normal.dot(p - plane.center);
    even += std::abs(off_m) <= cup.lip_conform_m;
    sum_m2 += off_m * off_m;
    const Eigen::Vector2d p_G = (X_BG.inverse() * p).head<2>();
    if (p_G.norm() < options.rim_inside * cup.radius_m) continue;
    const double turn = (std::atan2(p_G.y(), p_G.x()) / (2 * std::numbers::pi)) + 0.5;
    has_surface[std::min(options.rim_sectors - 1, static_cast<int>(turn * options.rim_sectors))] =
        1;
  }
  if (std::ranges::find(has_surface, 0) != has_surface.end()) {
    ++rejected["lip over an edge"];
    return std::nullopt;
  }
  const double count = static_cast<double>(under.size());
  const double rough_m = std::sqrt(sum_m2 / count);
  if (even < options.even_share * count || rough_m >= cup.lip_conform_m) {
    ++rejected["uneven under the lip"];
    return std::nullopt;
  }
  const SurfaceSegment& segment = seen.surface.segments[place.segment];
  const double lever = (segment.center_B - on_plane).norm() / options.lever_m;
  const double range_m = seen.top_m - seen.bottom_m;
  const double depth = range_m > 0 ? (seen.top_m - segment.top_m) / range_m : 0;
  Grasp grasp;
  grasp.X_WG = X_BG;
  grasp.score = (1 - rough_m / cup.lip_conform_m) / (1 + lever * lever) *
                (1 - options.tilt_share * tilt_rad / std::max(max_tilt_rad, 1e-9)) *
                (1 - options.height_share * depth);
  grasp.hypothesis = kNoHypothesis;
  grasp.tool = gripper.name;
  return grasp;
}

// One measured point of each cell of the floor plan, the one nearest to its center.
std::vector<const SurfacePoint*> PlacesOf(const ObservedSurface& surface, double spacing_m) {
  std::map<std::pair<int, int>, std::pair<double, const SurfacePoint*>> places;
  for (const SurfacePoint& point : surface.points) {
    if (point.segment < 0) continue;
    const Eigen::Array2d cells = point.p_B.head<2>().cast<double>().array() / spacing_m;
    const Eigen::Array2d cell = cells.floor();
    const double off = (cells - cell - 0.5).matrix().norm();
    const auto [place, is_new] =
        places.try_emplace({static_cast<int>(cell.x()), static_cast<int>(cell.y())}, off, &point);
    if (!is_new && off < place->second.first) place->second = {off, &point};
  }
  std::vector<const SurfacePoint*> chosen;
  for (const auto& [cell, place] : places) chosen.push_back(place.second);
  return chosen;
}

}  // namespace

void CloudSuctionOptions::Visit(SettingsVisitor& v) {
  const Range length{0.0005, 0.2}, share{0, 1};
  v.Real("spacing_m", spacing_m, length, "distance of the tested places, m");
  v.Integer("rim_sectors", rim_sectors, {4, 360}, "number of sectors of the rim");
  v.Real("rim_inside", rim_inside, share,
         "share of the lip's radius from which a point is near the rim");
  v.Real("rim_outside", rim_outside, {1, 3},
         "share of the lip's radius up to which a point is near the rim");
  v.Real("even_share", even_share, share,
         "minimum share of the points under the lip that it can follow");
  v.Real("lever_m", lever_m, length,
         "distance from the center of the segment that halves the score, m");
  v.Real("tilt_share", tilt_share, share, "share of the score that is lost at the largest tilt");
  v.Real("height_share", height_share, share, "share of the score that the lowest segment loses");
  v.Real("min_score", min_score, share, "minimum score of a reported grasp");
  v.Real("bin_clearance_m", bin_clearance_m, {0, 0.1}, "distance between hand and bin, m");
  v.Real("column_m", column_m, {0.001, 0.1}, "cell size of the floor-plan grid of the points, m");
  v.Real("apart_m", apart_m, {0, 0.1}, "minimum distance of two reported grasps, m");
  v.Group(
      "surface", [this](SettingsVisitor& g) { surface.Visit(g); }, "surface that the image shows");
}

CloudSuction::CloudSuction(const PlannerSetup& setup, const CloudSuctionOptions& options)
    : spec_(setup.spec), options_(options) {
  CheckSettings("CloudSuctionOptions", options_);
  for (const auto& tool : setup.tools) {
    const auto* cup = dynamic_cast<const SuctionCup*>(tool.get());
    CheckInput(cup != nullptr,
               fmt::format("planner cloud_suction needs suction cups, but gripper {} is a {}; "
                           "choose a cup of `pickbed list grippers` or planner cloud_antipodal",
                           tool->name, tool->mechanism()));
    cups_.push_back(cup);
  }
}

PlanResult CloudSuction::Plan(const PlannerInput& input) {
  PlanResult result;
  const ObservedSurface surface =
      ObserveSurface(input.frame, input.X_WC, input.bin, options_.surface);
  const PointGrid grid(surface.points, options_.column_m);
  SeenSurface seen{surface, grid, std::numeric_limits<double>::infinity(),
                   -std::numeric_limits<double>::infinity()};
  for (const SurfaceSegment& segment : surface.segments) {
    seen.bottom_m = std::min(seen.bottom_m, segment.top_m);
    seen.top_m = std::max(seen.top_m, segment.top_m);
  }
  std::vector<Grasp> found;
  for (const SurfacePoint* place : PlacesOf(surface, options_.spacing_m)) {
    for (const SuctionCup* cup : cups_) {
      const auto grasp =
          GraspAt(seen, *place, *cup, Radians(spec_.max_tilt_deg), options_, result.rejected);
      if (!grasp) continue;
      if (grasp->score < options_.min_score) {
        ++result.rejected["score too low"];
      } else {
        found.push_back(*grasp);
      }
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
  std::vector<Vector3d> obstacles_B;
  for (const SurfacePoint& point : surface.points) {
    obstacles_B.push_back(point.p_B.cast<double>());
  }
  std::vector<int> groups(obstacles_B.size(), 0);
  const ObstacleField field(std::move(obstacles_B), std::move(groups), options_.column_m);
  const std::vector<uint8_t> none{0};  // its points are one group
  const std::vector<AxisAlignedBox> bin_boxes =
      input.bin ? BinBoxes(input.bin->bin) : std::vector<AxisAlignedBox>();
  const Pose X_WB = input.bin ? input.bin->X_WB : Pose::Identity();
  std::vector<Vector3d> kept_B;
  for (Grasp& grasp : found) {
    const Vector3d p_B = grasp.X_WG.translation();
    const bool is_known = std::ranges::any_of(
        kept_B, [&](const Vector3d& kept) { return (kept - p_B).norm() < options_.apart_m; });
    if (is_known) continue;
    if (static_cast<int>(kept_B.size()) == input.max_grasps) {
      ++result.rejected["outranked"];
      continue;
    }
    const SuctionCup& cup = **std::ranges::find_if(
        cups_, [&](const SuctionCup* tool) { return tool->name == grasp.tool; });
    if (HandMeetsBin(cup, 0, grasp.X_WG, bin_boxes, options_.bin_clearance_m)) {
      ++result.rejected["bin wall"];
      continue;
    }
    if (field.FirstMet(grasp.X_WG, HandSweep(cup, 0), none, 0)) {
      ++result.rejected["stem or palm meets an instance"];
      continue;
    }
    kept_B.push_back(p_B);
    grasp.X_WG = X_WB * grasp.X_WG;
    result.grasps.push_back(grasp);
  }
  return result;
}

}  // namespace pickbed::grasp
