#include "eval/draw/grasp_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "eval/draw/canvas.h"
#include "eval/draw/outline.h"
#include "eval/draw/overlay.h"
#include "eval/draw/plot.h"
#include "scenes/base/error.h"
#include "sim/convex/convex_hull.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector3d;

constexpr int kGraspTileWidth = 460, kGraspTileHeight = 400, kGraspColumns = 3;
constexpr double kGraspFocal_px = 640;
constexpr Rgb8 kGraspPaper{238, 240, 243}, kBars{30, 90, 180};
constexpr int kBest = 8;        // hands in the views of the best grasps
constexpr int kOfAll = 30;      // hands in the view of all grasps
constexpr double kApart = 0.2;  // of the diameter; closer hands look the same
constexpr double kApart_rad = 0.7;
constexpr double kRod_m = 0.0011;       // half the thickness of a drawn hand
constexpr double kShownPalm_m = 0.012;  // drawn length of the palm
// Share of the distance at which the bounding sphere is fully in view; boxes rarely reach its
// border.
constexpr double kFill = 0.8;
constexpr int kBins = 20;

// Adds a rod of square section between two points in G.
void AddRod(const Vector3d& from, const Vector3d& to, const Pose& X_OG, TriangleMesh& mesh) {
  const Vector3d along = (to - from).normalized();
  const Vector3d u = kRod_m * along.unitOrthogonal(), v = along.cross(u);
  std::vector<Vector3d> corners;
  for (const Vector3d& end : {Vector3d(from - kRod_m * along), Vector3d(to + kRod_m * along)}) {
    for (const double a : {-1.0, 1.0}) {
      for (const double b : {-1.0, 1.0}) corners.push_back(X_OG * (end + a * u + b * v));
    }
  }
  const ConvexHull hull = MakeConvexHull(corners);
  TriangleMesh rod;
  rod.vertices = hull.vertices;
  rod.triangles = hull.triangles;
  rod.base_color = mesh.base_color;
  Append(rod, mesh);
}

// Adds a ring of rods in the plane normal to the approach.
void AddRing(const Vector3d& center, double radius_m, const Pose& X_OG, TriangleMesh& mesh) {
  constexpr int kSides = 12;
  const auto at = [&](int side) -> Vector3d {
    const double turn = 2 * std::numbers::pi * side / kSides;
    return center + radius_m * Vector3d(std::cos(turn), std::sin(turn), 0);
  };
  for (int side = 0; side < kSides; ++side) AddRod(at(side), at(side + 1), X_OG, mesh);
}

// Fingers or stem as rods through their boxes, connected in front of the palm. A jaw looks like a
// fork, a cup like a stem with a ring of its width at the end.
TriangleMesh HandGlyph(const GraspCandidate& candidate, const Gripper& gripper) {
  const auto opening = gripper.ApproachOpening_m(candidate.width_m);
  const auto boxes = gripper.Boxes(opening.value_or(candidate.width_m));
  TriangleMesh mesh;
  mesh.base_color = TurboColor(candidate.robust);
  const AxisAlignedBox& palm = boxes.back();
  const Vector3d joint = palm.center + Vector3d(0, 0, palm.half_size.z());
  for (size_t i = 0; i + 1 < boxes.size(); ++i) {
    const Vector3d front = boxes[i].center + Vector3d(0, 0, boxes[i].half_size.z());
    const Vector3d back(front.x(), front.y(), joint.z());
    AddRod(front, back, candidate.X_OG, mesh);
    if ((back - joint).norm() > kRod_m) AddRod(back, joint, candidate.X_OG, mesh);
  }
  if (boxes.size() == 2) {
    const Vector3d front = boxes[0].center + Vector3d(0, 0, boxes[0].half_size.z());
    AddRing(front, boxes[0].half_size.x(), candidate.X_OG, mesh);
  }
  AddRod(joint, joint - Vector3d(0, 0, kShownPalm_m), candidate.X_OG, mesh);
  return mesh;
}

Camera GraspCamera(const Vector3d& target, const Vector3d& from, double distance_m) {
  return CameraTowards(target, from, distance_m, kGraspTileWidth, kGraspTileHeight, kGraspFocal_px);
}

// Renderer of the object in gray and of hands in their colors.
class GraspRenderer {
 public:
  GraspRenderer(const ObjectModel& model, const std::vector<TriangleMesh>& hands) {
    // The object is drawn without its own colors, which would look like qualities.
    TriangleMesh object;
    object.vertices = model.mesh_O.vertices;
    object.triangles = model.mesh_O.triangles;
    object.normals = model.mesh_O.normals;
    instances_.push_back({renderer_.AddMesh(object), Pose::Identity(), 1});
    Bounds all = MeshBounds(object);
    for (const TriangleMesh& hand : hands) {
      instances_.push_back({renderer_.AddMesh(hand), Pose::Identity(), 2});
      const Bounds bounds = MeshBounds(hand);
      all.min = all.min.cwiseMin(bounds.min);
      all.max = all.max.cwiseMax(bounds.max);
    }
    center_ = all.center();
    distance_m_ = kFill * all.size().norm() * kGraspFocal_px / kGraspTileHeight;
  }

  Image<Rgb8> Observation(const Vector3d& from) {
    const Camera camera = GraspCamera(center_, from, distance_m_);
    Light light;
    light.ambient = 0.55;
    light.diffuse = 0.45;
    light.position_W = camera.X_WC() * Vector3d(-0.5, -0.6, -0.3);
    RenderedImage image = renderer_.Render(camera, instances_, light);
    for (size_t i = 0; i < image.color.size(); ++i) {
      if (image.depth_m.data()[i] == 0) image.color.data()[i] = kGraspPaper;
    }
    return std::move(image.color);
  }

 private:
  Renderer renderer_;
  std::vector<RenderInstance> instances_;
  Vector3d center_;
  double distance_m_ = 0;
};

// Histogram with equal bins over 0..top.
Image<Rgb8> Histogram(const std::vector<double>& values, double top, const char* label) {
  std::vector<int> counts(kBins, 0);
  for (const double value : values) {
    ++counts[std::clamp(static_cast<int>(value / top * kBins), 0, kBins - 1)];
  }
  ChartSeries steps{"", {{0, 0}}, kBars};
  for (int i = 0; i < kBins; ++i) {
    steps.points.emplace_back(top * i / kBins, counts[i]);
    steps.points.emplace_back(top * (i + 1) / kBins, counts[i]);
  }
  steps.points.emplace_back(top, 0);
  return DrawChart({label, "grasps", {steps}}, kGraspTileWidth, kGraspTileHeight);
}

double Median(std::vector<double> values) {
  const auto median = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

}  // namespace

std::vector<int> GraspsToDraw(const std::vector<GraspCandidate>& candidates, int wanted,
                              double object_diameter_m) {
  std::vector<int> order(candidates.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::make_pair(candidates[a].robust, candidates[a].epsilon) >
           std::make_pair(candidates[b].robust, candidates[b].epsilon);
  });
  std::vector<int> drawn;
  for (const int i : order) {
    if (static_cast<int>(drawn.size()) == wanted) break;
    const bool alike = std::any_of(drawn.begin(), drawn.end(), [&](int k) {
      const Pose &a = candidates[i].X_OG, &b = candidates[k].X_OG;
      return (a.translation() - b.translation()).norm() < kApart * object_diameter_m &&
             a.linear().col(2).dot(b.linear().col(2)) > std::cos(kApart_rad);
    });
    if (!alike) drawn.push_back(i);
  }
  return drawn;
}

Image<Rgb8> GraspSheet(const ObjectModel& model, const Gripper& gripper,
                       const std::vector<GraspCandidate>& candidates) {
  CheckInput(!candidates.empty(), "there is no grasp to draw");
  std::vector<TriangleMesh> best, of_all;
  for (const int i : GraspsToDraw(candidates, kBest, model.diameter_m)) {
    best.push_back(HandGlyph(candidates[i], gripper));
  }
  const size_t step = std::max<size_t>(1, candidates.size() / kOfAll);
  for (size_t i = 0; i < candidates.size(); i += step) {
    of_all.push_back(HandGlyph(candidates[i], gripper));
  }
  std::vector<double> quality, robust, epsilon;
  for (const GraspCandidate& candidate : candidates) {
    quality.push_back(candidate.quality);
    robust.push_back(candidate.robust);
    epsilon.push_back(candidate.epsilon);
  }
  const double top = std::max(1e-3, *std::max_element(epsilon.begin(), epsilon.end()));
  GraspRenderer of_best(model, best), of_all_grasps(model, of_all);
  const Image<Rgb8> sheet = ContactSheet(
      {of_best.Observation({1, -1.3, 0.9}), of_best.Observation({-1.2, 1, 0.5}),
       of_all_grasps.Observation({1, -1.3, 0.9}),
       Histogram(robust, 1, "robust: share of sampled errors survived"),
       Histogram(epsilon, top, "epsilon: smallest breaking wrench, in object weights"),
       Histogram(quality, 1, "quality of the contacts")},
      {fmt::format("{} and {}: {} of the best of {} grasps", model.name, gripper.name, best.size(),
                   candidates.size()),
       "the same grasps from behind", fmt::format("{} of all grasps, good and bad", of_all.size()),
       fmt::format("median {:.2f}", Median(robust)), fmt::format("median {:.2f}", Median(epsilon)),
       fmt::format("median {:.2f}", Median(quality))},
      kGraspColumns);
  std::vector<LegendEntry> legend;
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    legend.push_back({TurboColor(share), fmt::format("robust {:.2f}", share)});
  }
  return WithLegend(sheet, legend);
}

}  // namespace pickbed::eval
