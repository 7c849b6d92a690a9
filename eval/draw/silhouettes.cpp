#include "eval/draw/silhouettes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "eval/draw/bin_view.h"
#include "scenes/camera/footprint.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector2d;

constexpr double kMinRegion_px = 6;  // area in the picture; smaller regions are left out
constexpr double kSimplify_px = 0.3;

// Mean over neighbors on the closed curve. It removes the stairs of the pixels.
std::vector<cv::Point2f> Smoothed(const std::vector<cv::Point>& border) {
  constexpr int kReach = 3;
  const int count = static_cast<int>(border.size());
  const int reach = std::min(kReach, count / 6);
  std::vector<cv::Point2f> smooth(border.size());
  for (int i = 0; i < count; ++i) {
    cv::Point2f sum(0, 0);
    float weights = 0;
    for (int d = -reach; d <= reach; ++d) {
      const auto weight = static_cast<float>(reach + 1 - std::abs(d));
      sum += weight * cv::Point2f(border[(i + d + count) % count]);
      weights += weight;
    }
    smooth[i] = sum / weights;
  }
  return smooth;
}

// Bounding boxes of the ids 1 to `count`.
std::vector<cv::Rect> BoxesOfIds(const Image<uint16_t>& ids, int count) {
  std::vector<cv::Rect> boxes(count + 1);
  for (int y = 0; y < ids.height(); ++y) {
    const uint16_t* row = ids.row(y);
    for (int x = 0; x < ids.width();) {
      const uint16_t id = row[x];
      const int begin = x;
      while (x < ids.width() && row[x] == id) ++x;
      if (id > 0 && id <= count) boxes[id] |= cv::Rect(begin, y, x - begin, 1);
    }
  }
  return boxes;
}

Silhouette SilhouetteIn(const Image<uint16_t>& ids, uint16_t id, const cv::Rect& box, int fineness,
                        Holes holes) {
  Silhouette silhouette;
  if (box.empty()) return silhouette;
  cv::Mat1b mask(box.height + 2, box.width + 2, uint8_t{0});
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      mask(y + 1, x + 1) = ids(box.x + x, box.y + y) == id ? 255 : 0;
    }
  }
  const auto in_picture = [&](const cv::Point2f& p) {
    return Vector2d((p.x + box.x - 1 + 0.5) / fineness - 0.5,
                    (p.y + box.y - 1 + 0.5) / fineness - 0.5);
  };
  std::vector<std::vector<cv::Point>> borders;
  cv::findContours(mask, borders, holes == Holes::kWith ? cv::RETR_CCOMP : cv::RETR_EXTERNAL,
                   cv::CHAIN_APPROX_NONE);
  for (const std::vector<cv::Point>& border : borders) {
    if (cv::contourArea(border) < kMinRegion_px * fineness * fineness) continue;
    std::vector<cv::Point2f> simple;
    cv::approxPolyDP(Smoothed(border), simple, kSimplify_px * fineness, true);
    Polyline& curve = silhouette.curves.emplace_back();
    for (const cv::Point2f& p : simple) curve.push_back(in_picture(p));
  }
  cv::Mat1f distance;
  cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_5);
  double farthest = 0;
  cv::Point at;
  cv::minMaxLoc(distance, nullptr, &farthest, nullptr, &at);
  silhouette.inside = in_picture(cv::Point2f(at));
  silhouette.inside_px = farthest / fineness;
  return silhouette;
}

}  // namespace

RegionMap::RegionMap(const CameraIntrinsics& camera, int fineness)
    : camera_(EnlargedBy(camera, fineness)),
      fineness_(fineness),
      ids_(camera_.width(), camera_.height()),
      depth_m_(camera_.width(), camera_.height()) {}

void RegionMap::Add(const RasterMesh& mesh, const Pose& X_CO, double tie_m) {
  const uint16_t id = next_id_++;
  Bounds bounds;
  bounds.min.setConstant(std::numeric_limits<double>::max());
  bounds.max.setConstant(std::numeric_limits<double>::lowest());
  for (int axis = 0; axis < 3; ++axis) {
    if (mesh.position_O[axis].empty()) return;
    const auto [low, high] = std::ranges::minmax(mesh.position_O[axis]);
    bounds.min[axis] = low;
    bounds.max[axis] = high;
  }
  const Footprint footprint = FootprintOf(bounds, X_CO, camera_);
  if (!footprint.in_front || !footprint.Overlaps(camera_)) return;
  DrawnBox drawn(camera_);
  drawn.Include(footprint);
  const ImageBox box = drawn.box();
  raster_.Begin(camera_, box);
  raster_.Draw(mesh, X_CO, false);
  for (int y = 0; y < box.height; ++y) {
    const float* inverse = raster_.InverseDepths(y);
    const std::array<int, 2>& touched = raster_.Touched(y);
    for (int x = std::max(0, touched[0]); x < std::min(box.width, touched[1]); ++x) {
      if (inverse[x] == 0) continue;
      const float z = 1 / inverse[x];
      float& nearest = depth_m_(box.x + x, box.y + y);
      if (nearest > 0 && z > nearest - static_cast<float>(tie_m)) continue;
      nearest = z;
      ids_(box.x + x, box.y + y) = id;
    }
  }
  raster_.Clean();
}

bool RegionMap::Sees(const Eigen::Vector2d& pixel, double depth_m) const {
  const Eigen::Vector2d at = (pixel.array() + 0.5) * fineness_ - 0.5;
  const int u = static_cast<int>(std::lround(at.x())), v = static_cast<int>(std::lround(at.y()));
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x) {
      if (!depth_m_.Contains(x, y)) continue;
      const float z = depth_m_(x, y);
      if (z == 0 || z > depth_m) return true;
    }
  }
  return false;
}

std::vector<Silhouette> SilhouettesOf(const Image<uint16_t>& ids, int count, int fineness) {
  const std::vector<cv::Rect> boxes = BoxesOfIds(ids, count);
  std::vector<Silhouette> silhouettes;
  for (int id = 1; id <= count; ++id) {
    silhouettes.push_back(
        SilhouetteIn(ids, static_cast<uint16_t>(id), boxes[id], fineness, Holes::kWith));
  }
  return silhouettes;
}

std::vector<Silhouette> SilhouettesOf(const std::vector<PlacedObject>& placed,
                                      const ObjectSet& objects, const CameraIntrinsics& camera) {
  constexpr double kMixDiameters = 0.02;  // closer surfaces belong to the first object
  RegionMap map(camera);
  std::map<int, RasterMesh> meshes;
  for (const PlacedObject& p : placed) {
    const ObjectModel& model = *objects.at(p.object);
    const RasterMesh& mesh = meshes.try_emplace(p.object, model.mesh_O).first->second;
    map.Add(mesh, p.X_CO, kMixDiameters * model.diameter_m);
  }
  return SilhouettesOf(map.ids(), static_cast<int>(placed.size()), map.fineness());
}

Silhouette SilhouetteOf(const Image<uint16_t>& ids, uint16_t id, int fineness, Holes holes) {
  return SilhouetteIn(ids, id, BoxesOfIds(ids, id)[id], fineness, holes);
}

}  // namespace pickbed::eval
