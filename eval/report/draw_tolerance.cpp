#include "eval/report/draw_tolerance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "eval/report/draw.h"
#include "eval/report/draw_canvas.h"
#include "eval/report/draw_chart.h"
#include "eval/report/ticks.h"
#include "sim/renderer.h"

namespace pickbed {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTileWidth = 480, kTileHeight = 300, kColumns = 3;
constexpr int kLeft_px = 52, kRight_px = 20, kTop_px = 26, kBottom_px = 44;
constexpr int kCell_px = 44, kMaxPairColumns = 3;
constexpr Rgb8 kWhite{255, 255, 255}, kInk{40, 40, 40}, kGrid{226, 228, 232};
constexpr Rgb8 kObjectLine{0, 114, 178}, kObjectBand{190, 216, 234};
constexpr Rgb8 kGraspLine{213, 94, 0}, kGraspBand{244, 212, 186};
constexpr Rgb8 kKept{232, 244, 234}, kPaper{238, 240, 243};
constexpr Rgb8 kFails{222, 120, 50}, kSucceeds{70, 150, 210};
constexpr Rgb8 kAxisColors[3]{{210, 40, 40}, {20, 140, 40}, {40, 70, 220}};
constexpr const char* kAxisNames[3]{"x", "y", "z"};

// From errors and shares to pixels.
struct Frame {
  double x_min, x_max;
  double X(double x) const {
    return kLeft_px + (x - x_min) / (x_max - x_min) * (kTileWidth - kLeft_px - kRight_px);
  }
  double Y(double share) const {
    return kTileHeight - kBottom_px - share * (kTileHeight - kTop_px - kBottom_px);
  }
};

void DrawGrid(Canvas& canvas, const Frame& frame, const char* label) {
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    canvas.Line({frame.X(frame.x_min), frame.Y(share)}, {frame.X(frame.x_max), frame.Y(share)},
                kGrid);
    const std::string text = fmt::format("{:.0f} %", 100 * share);
    canvas.Text(text, kLeft_px - 6 - TextWidth(text, 0.38), int(frame.Y(share)) + 4, kInk, 0.38);
  }
  for (const double x : RoundTicks(frame.x_min, frame.x_max)) {
    canvas.Line({frame.X(x), frame.Y(0)}, {frame.X(x), frame.Y(1)}, kGrid);
    const std::string text = fmt::format("{:.6g}", x);
    canvas.Text(text, int(frame.X(x)) - TextWidth(text, 0.38) / 2, kTileHeight - kBottom_px + 16,
                kInk, 0.38);
  }
  canvas.Text(label, (kTileWidth - TextWidth(label, 0.42)) / 2, kTileHeight - 8, kInk, 0.42);
}

// Value of a broken line through (x, y) at `at`; the x ascend.
double Between(const std::vector<Vector2d>& line, double at) {
  for (size_t i = 1; i < line.size(); ++i) {
    if (at > line[i].x() && i + 1 < line.size()) continue;
    const double part = (at - line[i - 1].x()) / (line[i].x() - line[i - 1].x());
    return line[i - 1].y() + std::clamp(part, 0.0, 1.0) * (line[i].y() - line[i - 1].y());
  }
  return line.front().y();
}

Image<Rgb8> DrawCurve(const AxisCurve& curve) {
  const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
  Canvas canvas(kTileWidth, kTileHeight, kWhite);
  const Frame frame{curve.levels.front().offset, curve.levels.back().offset};
  const int top = int(frame.Y(1)), bottom = int(frame.Y(0));
  if (curve.region.high > curve.region.low) {
    const int from = int(frame.X(curve.region.low)), to = int(frame.X(curve.region.high));
    canvas.Fill(from, top, to - from, bottom - top, kKept);
  }
  std::vector<Vector2d> low, high, share;
  for (const LevelShare& level : curve.levels) {
    const Interval band = WilsonInterval(level.successes, level.tries);
    low.emplace_back(level.offset, band.low);
    high.emplace_back(level.offset, band.high);
    share.emplace_back(level.offset, level.share());
  }
  const Rgb8 band_color = axis.of_grasp ? kGraspBand : kObjectBand;
  for (int x = int(frame.X(frame.x_min)); x <= int(frame.X(frame.x_max)); ++x) {
    const double at = frame.x_min + (x - frame.X(frame.x_min)) * (frame.x_max - frame.x_min) /
                                        (frame.X(frame.x_max) - frame.X(frame.x_min));
    const int upper = int(frame.Y(Between(high, at))), lower = int(frame.Y(Between(low, at)));
    canvas.Fill(x, upper, 1, std::max(1, lower - upper), band_color);
  }
  DrawGrid(canvas, frame, fmt::format("error {}, {}", curve.help, axis.unit).c_str());
  const Rgb8 line_color = axis.of_grasp ? kGraspLine : kObjectLine;
  for (size_t i = 0; i < share.size(); ++i) {
    const Vector2d here(frame.X(share[i].x()), frame.Y(share[i].y()));
    if (i > 0) {
      canvas.Line({frame.X(share[i - 1].x()), frame.Y(share[i - 1].y())}, here, line_color, 2);
    }
    canvas.Dot(here, 3, line_color);
  }
  return canvas.Take();
}

Camera TowardsMiddle(const Vector3d& middle_W, const Vector3d& from_W, double distance_m) {
  Camera camera;
  const double focal_px = 560;
  camera.intrinsics = {
      kTileWidth, kTileHeight, focal_px, focal_px, 0.5 * (kTileWidth - 1), 0.5 * (kTileHeight - 1)};
  camera.X_WC = LookAt(middle_W + distance_m * from_W.normalized(), middle_W, Vector3d::UnitZ());
  return camera;
}

// Axes of a frame with their names.
void DrawAxes(Canvas& canvas, const Camera& camera, const Pose& X_WF, double length_m) {
  const Pose X_CF = camera.X_WC.inverse() * X_WF;
  const Vector2d origin = Project(camera.intrinsics, X_CF.translation());
  for (int i = 0; i < 3; ++i) {
    const Vector2d tip = Project(camera.intrinsics, X_CF * Vector3d(length_m * Vector3d::Unit(i)));
    canvas.Line(origin, tip, kAxisColors[i], 3);
    canvas.Label(kAxisNames[i], tip + 12 * (tip - origin).normalized(), 0.5);
  }
}

// How far a gripper stands back from the origin of G.
double ReachOf(const GripperSpec& gripper) {
  const MechanismRow& row = MechanismOf(gripper);
  double reach_m = 0;
  for (const auto& boxes :
       {row.boxes(gripper, row.most_open_m(gripper)), row.soft_boxes(gripper)}) {
    for (const AxisAlignedBox& box : boxes) {
      reach_m = std::max(reach_m, box.half_size.z() - box.center.z());
    }
  }
  return reach_m;
}

class Studio {
 public:
  explicit Studio(const ToleranceStudy& study)
      : part_(*study.table.objects[0]), table_(study.table) {
    mesh_ = renderer_.AddMesh(part_.mesh_O);
  }

  Image<Rgb8> PartTile(const Vector3d& middle_O) {
    const Camera camera = TowardsMiddle(middle_O, {1, -1.3, 0.9}, 2.6 * part_.diameter_m);
    Canvas canvas(Picture(camera, Pose::Identity()));
    DrawAxes(canvas, camera, Translation(middle_O), 0.62 * part_.diameter_m);
    return canvas.Take();
  }

  Image<Rgb8> HandTile(const TableGrasp& held, const Vector3d& middle_O) {
    const Pose& X_WO = table_.places[held.place].scene.objects[0].X_WO;
    Grasp grasp;
    grasp.X_WG = X_WO * held.candidate.X_OG;
    grasp.width_m = held.candidate.width_m;
    const double reach_m = ReachOf(table_.gripper);
    // Seen along y of G, a little from above.
    Vector3d from = grasp.X_WG.linear().col(1);
    from.z() = 0;
    from = from.normalized() + Vector3d(0, 0, 0.45) + 0.5 * grasp.X_WG.linear().col(0);
    const Vector3d middle_W = 0.5 * (X_WO * middle_O + grasp.X_WG * Vector3d(0, 0, -0.7 * reach_m));
    const Camera camera = TowardsMiddle(middle_W, from, 2.4 * (part_.diameter_m + reach_m));
    RgbdFrame frame;
    frame.color = Picture(camera, X_WO);
    Canvas canvas(DrawOverlay({frame, camera, table_.objects, {}, {}, &grasp, &table_.gripper}));
    DrawAxes(canvas, camera, grasp.X_WG, 0.5 * reach_m);
    return canvas.Take();
  }

 private:
  Image<Rgb8> Picture(const Camera& camera, const Pose& X_WO) {
    Light light;
    light.position_W = camera.X_WC * Vector3d(-0.5, -0.6, -0.3);
    RenderedImage image =
        renderer_.Render(camera, std::vector<RenderInstance>{{mesh_, X_WO, 1}}, light);
    for (size_t i = 0; i < image.color.size(); ++i) {
      if (image.depth_m.data()[i] == 0) image.color.data()[i] = kPaper;
    }
    return std::move(image.color);
  }

  const ObjectModel& part_;
  const Table& table_;
  Renderer renderer_;
  int mesh_ = 0;
};

std::vector<std::string> KeyFigures(const ToleranceStudy& study, const ToleranceFigures& figures) {
  const Interval at_truth = WilsonInterval(figures.at_truth.successes, figures.at_truth.tries);
  const auto graspable = std::count_if(study.table.places.begin(), study.table.places.end(),
                                       [](const RestingPlace& place) { return place.graspable; });
  std::vector<std::string> lines{
      fmt::format("{} with {}", figures.object, figures.gripper),
      fmt::format("grasps\t{} of {} candidates", study.options.grasps,
                  study.table.candidates.size()),
      fmt::format("resting poses\t{}, {} with grasps", study.table.places.size(), graspable),
      fmt::format("without an error\t{:.1f} % [{:.1f}, {:.1f}]", 100 * figures.at_truth.share(),
                  100 * at_truth.low, 100 * at_truth.high),
      fmt::format("green\terrors that keep {:.0f} % of that", 100 * study.options.keep_share),
      fmt::format("AUC of {} held-out picks", figures.test_picks)};
  for (const Predictor& p : figures.predictors) {
    if (!p.auc.is_known()) continue;  // all picks had one outcome
    lines.push_back(fmt::format("  {}\t{:.3f} [{:.3f}, {:.3f}]", p.name, p.auc.auc,
                                p.auc.interval.low, p.auc.interval.high));
  }
  return lines;
}

Rgb8 Mixed(const Rgb8& a, const Rgb8& b, double share) {
  const auto mix = [&](uint8_t p, uint8_t q) {
    return static_cast<uint8_t>(std::lround(p + share * (q - p)));
  };
  return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)};
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
  return fmt::format("{:+.1f}{} .. {:+.1f}{} {}", region.low, region.low_open ? " or less" : "",
                     region.high, region.high_open ? " or more" : "", unit);
}

Image<Rgb8> DrawToleranceSheet(const ToleranceStudy& study, const ToleranceFigures& figures) {
  Studio studio(study);
  const Vector3d& middle_O = figures.model.surface_mean_O;
  std::vector<Image<Rgb8>> tiles{studio.PartTile(middle_O),
                                 studio.HandTile(study.grasps[study.options.grasps / 2], middle_O),
                                 DrawTable(KeyFigures(study, figures), kTileWidth, kTileHeight)};
  std::vector<std::string> captions{"Axes of the part, at the middle of its surface",
                                    "Axes of the hand, at one of the grasps", "Key figures"};
  for (const AxisCurve& curve : figures.axes) {
    const ErrorAxis& axis = ErrorAxisTable()[curve.axis];
    tiles.push_back(DrawCurve(curve));
    captions.push_back(
        fmt::format("{}: picks succeed from {}", axis.name, RegionText(curve.region, axis.unit)));
  }
  return ContactSheet(tiles, captions, kColumns);
}

Image<Rgb8> DrawPairSheet(const ToleranceFigures& figures) {
  std::vector<Image<Rgb8>> tiles;
  std::vector<std::string> captions;
  for (const PairMap& map : figures.pairs) {
    const ErrorAxis& a = ErrorAxisTable()[map.axis[0]];
    const ErrorAxis& b = ErrorAxisTable()[map.axis[1]];
    tiles.push_back(DrawPair(map, figures.axes));
    captions.push_back(fmt::format("{} and {}: percent of picks that succeed", a.name, b.name));
  }
  return ContactSheet(tiles, captions, std::min<int>(kMaxPairColumns, int(tiles.size())));
}

}  // namespace pickbed
