#include "eval/draw/object_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "eval/draw/outline.h"
#include "eval/draw/overlay.h"
#include "eval/stats/statistics.h"
#include "sim/convex/convex_hull.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector3d;

constexpr int kObjectTileWidth = 320, kObjectTileHeight = 260, kObjectColumns = 4;
constexpr int kRestingTiles = 4;
constexpr double kDistance = 2.6;  // of the camera, in diameters
constexpr double kExplode = 0.35;  // relative displacement of the pieces in the exploded view
constexpr double kObjectFocal_px = 520;
constexpr Rgb8 kObjectPaper{238, 240, 243};

Camera ObjectCamera(const Vector3d& target, const Vector3d& from, double distance_m) {
  return CameraTowards(target, from, distance_m, kObjectTileWidth, kObjectTileHeight,
                       kObjectFocal_px);
}

Rgb8 PieceColor(int i) {
  cv::Mat3b pixel(1, 1, cv::Vec3b(static_cast<uint8_t>(i * 67 % 180), 150, 235));
  cv::cvtColor(pixel, pixel, cv::COLOR_HSV2RGB);
  return {pixel(0, 0)[0], pixel(0, 0)[1], pixel(0, 0)[2]};
}

class ObjectTiles {
 public:
  explicit ObjectTiles(const MadeObject& made) : made_(made), model_(made.model) {
    center_O_ = MeshBounds(model_.mesh_O).center();
    distance_m_ = kDistance * model_.diameter_m;
    mesh_ = renderer_.AddMesh(model_.mesh_O);
  }

  void AddViews();
  void AddSymmetries();
  void AddPieces();
  void AddResting();
  Image<Rgb8> Sheet() const { return ContactSheet(tiles_, captions_, kObjectColumns); }

 private:
  Image<Rgb8> Picture(const Camera& camera, const std::vector<RenderInstance>& instances) {
    Light light;
    light.position_W = camera.X_WC() * Vector3d(-0.5, -0.6, -0.3);
    RenderedImage image = renderer_.Render(camera, instances, light);
    for (size_t i = 0; i < image.color.size(); ++i) {
      if (image.depth_m.data()[i] == 0) image.color.data()[i] = kObjectPaper;
    }
    return std::move(image.color);
  }
  void Add(Image<Rgb8> tile, std::string caption) {
    tiles_.push_back(std::move(tile));
    captions_.push_back(std::move(caption));
  }

  const MadeObject& made_;
  const ObjectModel& model_;
  Renderer renderer_;
  int mesh_ = 0;
  Vector3d center_O_;
  double distance_m_ = 0;
  std::vector<Image<Rgb8>> tiles_;
  std::vector<std::string> captions_;
};

void ObjectTiles::AddViews() {
  const Vector3d size_mm = 1e3 * MeshBounds(model_.mesh_O).size();
  const std::array<std::pair<Vector3d, std::string>, 3> views{
      {{{1, -1.3, 0.9},
        fmt::format("{:.1f} x {:.1f} x {:.1f} mm", size_mm.x(), size_mm.y(), size_mm.z())},
       {{0, 0, 1}, "along -z"},
       {{0, -1, 0}, "along y"}}};
  for (const auto& [from, caption] : views) {
    Add(Picture(ObjectCamera(center_O_, from, distance_m_), {{mesh_, Pose::Identity(), 1}}),
        caption);
  }
}

// Continuous symmetry axes are red, axes of discrete rotations blue.
void ObjectTiles::AddSymmetries() {
  const Camera camera = ObjectCamera(center_O_, {1, -1.3, 0.9}, distance_m_);
  Image<Rgb8> tile = Picture(camera, {{mesh_, Pose::Identity(), 1}});
  cv::Mat canvas(tile.height(), tile.width(), CV_8UC3, tile.data());
  const Pose X_CO = camera.X_CW();
  const auto line = [&](const Vector3d& point_O, const Vector3d& axis_O, const cv::Scalar& color) {
    const Vector3d near_center_O = point_O + axis_O * axis_O.dot(center_O_ - point_O);
    const auto pixel = [&](double along) {
      const Vector3d p_O = near_center_O + along * model_.diameter_m * axis_O;
      const Eigen::Vector2d p = Project(camera.intrinsics, X_CO * p_O);
      return cv::Point(static_cast<int>(p.x()), static_cast<int>(p.y()));
    };
    cv::line(canvas, pixel(-0.62), pixel(0.62), color, 2, cv::LINE_AA);
  };
  for (const Pose& S : model_.symmetries_O.discrete_O) {
    line(PointOnAxis(S), Eigen::AngleAxisd(S.linear()).axis(), {60, 110, 230});
  }
  for (const ContinuousSymmetry& s : model_.symmetries_O.continuous_O) {
    line(s.offset_O, s.axis_O, {220, 60, 50});
  }
  Add(std::move(tile), SymmetryText(model_.symmetries_O));
}

void ObjectTiles::AddPieces() {
  std::vector<RenderInstance> together, apart;
  for (size_t i = 0; i < model_.convex_pieces_O.size(); ++i) {
    const ConvexHull hull = MakeConvexHull(model_.convex_pieces_O[i].vertices_O);
    TriangleMesh mesh;
    mesh.vertices = hull.vertices;
    mesh.triangles = hull.triangles;
    mesh.base_color = PieceColor(static_cast<int>(i));
    const int handle = renderer_.AddMesh(mesh);
    const Vector3d away = kExplode * (MeshBounds(mesh).center() - center_O_);
    together.push_back({handle, Pose::Identity(), 1});
    apart.push_back({handle, Translation(away), 1});
  }
  const Vector3d from(1, -1.3, 0.9);
  Add(Picture(ObjectCamera(center_O_, from, distance_m_), together),
      fmt::format("{} convex pieces", model_.convex_pieces_O.size()));
  Add(Picture(ObjectCamera(center_O_, from, (1 + kExplode) * distance_m_), apart),
      fmt::format("bulge {:.2f} mm, volume {:+.1f} %", 1e3 * made_.quality.bulge_m,
                  100 * made_.quality.volume_error));
}

void ObjectTiles::AddResting() {
  Bin table;
  table.inner_size_m = {2 * model_.diameter_m, 2 * model_.diameter_m, 0};
  const int table_mesh = renderer_.AddMesh(BinMesh(table));
  const size_t shown = std::min<size_t>(kRestingTiles, made_.resting.size());
  for (size_t i = 0; i < shown; ++i) {
    const RestingPose& pose = made_.resting[i];
    const Camera camera = ObjectCamera(pose.X_WO * center_O_, {1, -1.3, 0.9}, distance_m_);
    Add(Picture(camera, {{mesh_, pose.X_WO, 1}, {table_mesh, Pose::Identity(), 0}}),
        "probability of this resting pose: " + WholePercentText(pose.probability));
  }
}

std::string List(const Vector3d& v) {
  const Vector3d clean = (v * 1e3).array().round() / 1e3 + 0.0;
  return fmt::format("[{:g}, {:g}, {:g}]", clean.x(), clean.y(), clean.z());
}

// Rounds to a multiple of `step`, without a negative zero.
double Rounded(double value, double step) { return std::round(value / step) * step + 0.0; }

// "z" for a coordinate axis, else its numbers.
std::string AxisText(const Vector3d& axis) {
  constexpr double kAligned = 1 - 1e-6;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis[k]) > kAligned) return std::string(1, "xyz"[k]);
  }
  return List(axis);
}

// "6-fold about z, and flips" for rotations about one axis, with or without half turns across it.
// Empty for another group.
std::string FoldText(const std::vector<Pose>& rotations) {
  constexpr double kAlong = 1 - 1e-4, kAcross = 1e-2;
  std::vector<Vector3d> axes;
  for (const Pose& X : rotations) axes.push_back(Eigen::AngleAxisd(X.linear()).axis());
  size_t best = 0;
  Vector3d main = Vector3d::UnitZ();
  for (const Vector3d& axis : axes) {
    const size_t along = std::count_if(axes.begin(), axes.end(), [&](const Vector3d& other) {
      return std::abs(axis.dot(other)) > kAlong;
    });
    if (along > best) {
      best = along;
      main = axis;
    }
  }
  const size_t across = std::count_if(axes.begin(), axes.end(), [&](const Vector3d& other) {
    return std::abs(main.dot(other)) < kAcross;
  });
  const size_t order = best + 1;
  if (best + across != axes.size() || (across != 0 && across != order)) return "";
  return fmt::format("{}-fold about {}{}", order, AxisText(main), across > 0 ? ", and flips" : "");
}

}  // namespace

Image<Rgb8> ObjectSheet(const MadeObject& made) {
  ObjectTiles tiles(made);
  tiles.AddViews();
  tiles.AddSymmetries();
  tiles.AddPieces();
  tiles.AddResting();
  return tiles.Sheet();
}

std::string SymmetryText(const SymmetrySet& symmetries) {
  if (symmetries.trivial()) return "no symmetry";
  if (symmetries.continuous_O.size() > 1) return "all rotations (a sphere)";
  std::string text;
  for (const ContinuousSymmetry& s : symmetries.continuous_O) {
    text = fmt::format("any rotation about {}", List(s.axis_O));
  }
  const size_t turns = symmetries.discrete_O.size();
  if (turns == 0) return text;
  if (!text.empty()) return text + " and upside down";
  if (const std::string fold = FoldText(symmetries.discrete_O); !fold.empty()) return fold;
  return fmt::format("{} rotation{}", turns, turns == 1 ? "" : "s");
}

std::string ObjectText(const MadeObject& made) {
  const ObjectModel& model = made.model;
  std::string text;
  const auto line = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:<16}{}\n", name, value);
  };
  for (const std::string& fixed : made.inspected.fixed) line("corrected", fixed);
  for (const std::string& note : made.inspected.notes) line("note", note);
  const Vector3d size_mm = 1e3 * MeshBounds(model.mesh_O).size();
  line("size",
       fmt::format("{:.1f} x {:.1f} x {:.1f} mm, diameter {:.1f} mm, {} faces{}", size_mm.x(),
                   size_mm.y(), size_mm.z(), 1e3 * model.diameter_m, model.mesh_O.triangles.size(),
                   made.inspected.watertight ? ", closed" : ", open"));
  const Eigen::Matrix3d& I = model.mass.inertia_com_O;
  line("mass", fmt::format("{:.4g} kg, centre of mass {} m{}", model.mass.mass_kg,
                           List(model.mass.com_O), made.mass_from_hull ? ", from the hull" : ""));
  if (made.mass_by_default_density) {
    line("note", fmt::format("mass from the default density {:g} kg/m3 (plastic); steel is 7850",
                             kDefaultDensity_kgpm3));
  }
  // Smaller products of inertia are rounding errors.
  const double negligible = 1e-6 * I.diagonal().cwiseAbs().maxCoeff();
  const auto off = [&](int row, int column) {
    return std::abs(I(row, column)) > negligible ? I(row, column) : 0.0;
  };
  line("inertia", fmt::format("xx {:.3g} yy {:.3g} zz {:.3g} xy {:.3g} xz {:.3g} yz {:.3g} kg m2",
                              I(0, 0), I(1, 1), I(2, 2), off(0, 1), off(0, 2), off(1, 2)));
  line("convex pieces",
       fmt::format(
           "{} with {} vertices; largest bulge {:.2f} mm, volume {:+.1f} %, misses {:.2f} mm",
           made.quality.pieces, made.quality.vertices, 1e3 * made.quality.bulge_m,
           Rounded(100 * made.quality.volume_error, 0.1), 1e3 * made.quality.missed_m));
  line("symmetries", SymmetryText(model.symmetries_O));
  for (const RestingPose& pose : made.resting) {
    line("resting poses",
         fmt::format("{:>3.0f} % with {} up", 100 * pose.probability, List(pose.up_O)));
  }
  std::string seconds;
  for (const MakeStageTime& stage : made.seconds) {
    seconds += fmt::format("{}{} {:.2f}", seconds.empty() ? "" : ", ", stage.stage, stage.seconds);
  }
  line("seconds", seconds);
  return text;
}

}  // namespace pickbed::eval
