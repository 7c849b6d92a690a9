#include "eval/tolerance/draw.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "eval/draw/canvas.h"
#include "eval/draw/overlay.h"
#include "eval/draw/plot.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTileWidth = 480, kTileHeight = 300, kSheetColumns = 3;
constexpr int kCell_px = 44, kMaxPairColumns = 3;
constexpr Rgb8 kWhite{255, 255, 255}, kInk{40, 40, 40};
constexpr Rgb8 kObjectLine{0, 114, 178}, kGraspLine{213, 94, 0};
constexpr Rgb8 kPaper{238, 240, 243};
constexpr Rgb8 kFails{222, 120, 50}, kSucceeds{70, 150, 210};
constexpr Rgb8 kAxisColors[3]{{210, 40, 40}, {20, 140, 40}, {40, 70, 220}};
constexpr const char* kAxisNames[3]{"x", "y", "z"};

Image<Rgb8> DrawCurve(const AxisCurve& curve) {
  const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
  ChartSeries share{"", {}, axis.of_grasp ? kGraspLine : kObjectLine};
  for (const LevelShare& level : curve.levels) {
    share.points.emplace_back(level.offset, level.share());
    share.band.push_back(level.band());
  }
  ChartSeries dots{"", share.points, share.color, true};
  Chart chart{fmt::format("error {}, {}", curve.help, axis.unit), "", {share, dots}, true};
  chart.marked_x = Interval{curve.region.low, curve.region.high};
  return DrawChart(chart, kTileWidth, kTileHeight);
}

Camera TowardsCenter(const Vector3d& center_W, const Vector3d& from_W, double distance_m) {
  Camera camera;
  const double focal_px = 560;
  camera.intrinsics = {
      kTileWidth, kTileHeight, focal_px, focal_px, 0.5 * (kTileWidth - 1), 0.5 * (kTileHeight - 1)};
  camera.SetPose(LookAt(center_W + distance_m * from_W.normalized(), center_W, Vector3d::UnitZ()));
  return camera;
}

// Draws the axes of a frame with their names.
void DrawAxes(Canvas& canvas, const Camera& camera, const Pose& X_WF, double length_m) {
  const Pose X_CF = camera.X_CW() * X_WF;
  const Vector2d origin = Project(camera.intrinsics, X_CF.translation());
  for (int i = 0; i < 3; ++i) {
    const Vector2d tip = Project(camera.intrinsics, X_CF * Vector3d(length_m * Vector3d::Unit(i)));
    canvas.Line(origin, tip, kAxisColors[i], 3);
    canvas.Label(kAxisNames[i], tip + 12 * (tip - origin).normalized(), 0.5);
  }
}

// Extent of a gripper behind the origin of G.
double ReachOf(const Gripper& gripper) {
  double reach_m = 0;
  for (const auto& boxes : {gripper.Boxes(gripper.MaxOpening_m()), gripper.SoftBoxes()}) {
    for (const AxisAlignedBox& box : boxes) {
      reach_m = std::max(reach_m, box.half_size.z() - box.center.z());
    }
  }
  return reach_m;
}

class TileRenderer {
 public:
  explicit TileRenderer(const ToleranceStudy& study)
      : object_(*study.table.objects[0]), table_(study.table) {
    mesh_ = renderer_.AddMesh(object_.mesh_O);
  }

  Image<Rgb8> ObjectTile(const Vector3d& center_O) {
    const Camera camera = TowardsCenter(center_O, {1, -1.3, 0.9}, 2.6 * object_.diameter_m);
    Canvas canvas(Picture(camera, Pose::Identity()));
    DrawAxes(canvas, camera, Translation(center_O), 0.62 * object_.diameter_m);
    return canvas.Take();
  }

  Image<Rgb8> HandTile(const TableGrasp& held, const Vector3d& center_O) {
    const Pose& X_WO = table_.places[held.place].scene.objects[0].X_WO;
    Grasp grasp;
    grasp.X_WG = X_WO * held.candidate.X_OG;
    grasp.width_m = held.candidate.width_m;
    const double reach_m = ReachOf(*table_.gripper);
    // Observation along y of G, slightly from above.
    Vector3d from = grasp.X_WG.linear().col(1);
    from.z() = 0;
    from = from.normalized() + Vector3d(0, 0, 0.45) + 0.5 * grasp.X_WG.linear().col(0);
    const Vector3d center_W = 0.5 * (X_WO * center_O + grasp.X_WG * Vector3d(0, 0, -0.7 * reach_m));
    const Camera camera = TowardsCenter(center_W, from, 2.4 * (object_.diameter_m + reach_m));
    Canvas canvas(Picture(camera, X_WO));
    DrawHand(canvas, camera.intrinsics,
             {*table_.gripper, camera.X_CW() * grasp.X_WG, grasp.width_m});
    DrawAxes(canvas, camera, grasp.X_WG, 0.5 * reach_m);
    return canvas.Take();
  }

 private:
  Image<Rgb8> Picture(const Camera& camera, const Pose& X_WO) {
    Light light;
    light.position_W = camera.X_WC() * Vector3d(-0.5, -0.6, -0.3);
    RenderedImage image =
        renderer_.Render(camera, std::vector<RenderInstance>{{mesh_, X_WO, 1}}, light);
    for (size_t i = 0; i < image.color.size(); ++i) {
      if (image.depth_m.data()[i] == 0) image.color.data()[i] = kPaper;
    }
    return std::move(image.color);
  }

  const ObjectModel& object_;
  const Table& table_;
  Renderer renderer_;
  int mesh_ = 0;
};

std::vector<std::string> KeyNumbers(const ToleranceStudy& study,
                                    const ToleranceStatistics& statistics) {
  const auto graspable = std::count_if(study.table.places.begin(), study.table.places.end(),
                                       [](const RestingPlace& place) { return place.graspable; });
  std::vector<std::string> lines{
      fmt::format("{} with {}", statistics.object, statistics.gripper),
      fmt::format("grasps\t{} of {} candidates", study.options.grasps,
                  study.table.candidates.size()),
      fmt::format("resting poses\t{}, {} with grasps", study.table.places.size(), graspable),
      fmt::format("without error\t{} {}", PercentText(statistics.at_truth.share()),
                  BandText(statistics.at_truth)),
      fmt::format("green\terrors that keep {} of this rate",
                  WholePercentText(study.options.keep_share)),
      fmt::format("AUC of {} held-out picks", statistics.test_picks)};
  for (const Predictor& p : statistics.predictors) {
    if (!p.auc.is_known()) continue;  // all picks had the same outcome
    lines.push_back(fmt::format("  {}\t{}", p.name, AucText(p.auc)));
  }
  return lines;
}

Rgb8 ShareColor(double share) {
  return share < 0.5 ? Mixed(kFails, kWhite, 2 * share) : Mixed(kWhite, kSucceeds, 2 * share - 1);
}

Image<Rgb8> DrawPair(const PairMap& map, const std::vector<AxisCurve>& axes) {
  const ErrorAxis& a = ErrorAxisTable()[map.axis[0]];
  const ErrorAxis& b = ErrorAxisTable()[map.axis[1]];
  const int columns = int(map.offsets_a.size()), rows = int(map.offsets_b.size());
  const int left = 112, top = 16, width = left + columns * kCell_px + 20;
  Canvas canvas(std::max(width, 420), top + rows * kCell_px + 74, kWhite);
  for (int row = 0; row < rows; ++row) {
    const int y = top + (rows - 1 - row) * kCell_px;
    for (int column = 0; column < columns; ++column) {
      const double share = map.cells[row * columns + column].share();
      const int x = left + column * kCell_px;
      canvas.Fill(x, y, kCell_px - 1, kCell_px - 1, ShareColor(share));
      const std::string text = fmt::format("{:.0f}", 100 * share);
      canvas.Text(text, x + (kCell_px - TextWidth(text, 0.38)) / 2, y + kCell_px / 2 + 4, kInk,
                  0.38);
    }
    const std::string text = fmt::format("{:+g}", map.offsets_b[row]);
    canvas.Text(text, left - 8 - TextWidth(text, 0.4), y + kCell_px / 2 + 4, kInk, 0.4);
  }
  for (int column = 0; column < columns; ++column) {
    const std::string text = fmt::format("{:+g}", map.offsets_a[column]);
    canvas.Text(text, left + column * kCell_px + (kCell_px - TextWidth(text, 0.4)) / 2,
                top + rows * kCell_px + 18, kInk, 0.4);
  }
  canvas.Text(fmt::format("{}, {}", b.name, b.unit), 4, top + rows * kCell_px / 2 - 4, kInk, 0.4);
  const std::string label = fmt::format("{}: error {}, {}", a.name, axes[map.axis[0]].help, a.unit);
  canvas.Text(label, 10, top + rows * kCell_px + 42, kInk, 0.42);
  canvas.Text(fmt::format("{}: error {}, {}", b.name, axes[map.axis[1]].help, b.unit), 10,
              top + rows * kCell_px + 62, kInk, 0.42);
  return canvas.Take();
}

}  // namespace

std::string RegionText(const ToleranceRegion& region, const char* unit) {
  return fmt::format("{:+.1f}{} to {:+.1f}{} {}", region.low, region.low_open ? " or less" : "",
                     region.high, region.high_open ? " or more" : "", unit);
}

Image<Rgb8> DrawToleranceSheet(const ToleranceStudy& study, const ToleranceStatistics& statistics) {
  TileRenderer tile_renderer(study);
  const Vector3d& center_O = statistics.model.surface_mean_O;
  std::vector<Image<Rgb8>> tiles{
      tile_renderer.ObjectTile(center_O),
      tile_renderer.HandTile(study.grasps[study.options.grasps / 2], center_O),
      DrawTable(KeyNumbers(study, statistics), kTileWidth, kTileHeight)};
  std::vector<std::string> captions{"Axes of the object, at the center of its surface",
                                    "Axes of the gripper, at one of the grasps", "Key numbers"};
  for (const AxisCurve& curve : statistics.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    tiles.push_back(DrawCurve(curve));
    captions.push_back(
        fmt::format("{}: region of success {}", axis.name, RegionText(curve.region, axis.unit)));
  }
  return ContactSheet(tiles, captions, kSheetColumns);
}

Image<Rgb8> DrawPairSheet(const ToleranceStatistics& statistics) {
  std::vector<Image<Rgb8>> tiles;
  std::vector<std::string> captions;
  for (const PairMap& map : statistics.pairs) {
    const ErrorAxis& a = ErrorAxisTable()[map.axis[0]];
    const ErrorAxis& b = ErrorAxisTable()[map.axis[1]];
    tiles.push_back(DrawPair(map, statistics.axes));
    captions.push_back(fmt::format("{} and {}: percentage of picks that succeed", a.name, b.name));
  }
  return ContactSheet(tiles, captions, std::min<int>(kMaxPairColumns, int(tiles.size())));
}

}  // namespace pickbed::eval
