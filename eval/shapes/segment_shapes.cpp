#include "eval/shapes/segment_shapes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "eval/shapes/completion_choice.h"
#include "perception/completion/segment_window.h"
#include "perception/segments/segment_cover.h"
#include "scenes/base/error.h"
#include "scenes/geometry/mesh_query.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector3d;

std::unique_ptr<perception::ShapeCompleter> CompleterFor(const std::string& completion) {
  if (completion == kTrueShapes) return nullptr;
  const perception::CompletionOptions options = CompletionNamed(completion);
  std::vector<std::string> known = perception::CompleterNames();
  const bool is_known = std::ranges::find(known, options.method) != known.end();
  known.push_back(kTrueShapes);
  CheckInput(is_known, UnknownNameMessage("completion method", completion, known));
  return perception::MakeCompleter(options);
}

std::optional<KnownBackground> BackgroundOf(const grasp::PlannerInput& input) {
  if (!input.bin) return std::nullopt;
  return KnownBackground{input.bin->bin, input.X_WC.inverse() * input.bin->X_WB};
}

std::optional<perception::FloorPlane> FloorOf(const std::optional<KnownBackground>& background) {
  if (!background) return std::nullopt;
  perception::FloorPlane floor;
  floor.normal_C = background->X_CB.linear().col(2).cast<float>();
  floor.offset_m = floor.normal_C.dot(background->X_CB.translation().cast<float>());
  return floor;
}

// The instance that covers most of a segment; kNoInstance if most of it is background.
InstanceId InstanceOf(const Image<uint16_t>& labels, int label, const Image<uint16_t>& ids) {
  std::map<uint16_t, int> pixels;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels.data()[i] == label) ++pixels[ids.data()[i]];
  }
  const auto largest =
      std::max_element(pixels.begin(), pixels.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return largest == pixels.end() || largest->first == 0 ? kNoInstance
                                                        : InstanceId(largest->first - 1);
}

}  // namespace

perception::SegmentView ViewOf(const RgbdFrame& frame, const Image<uint16_t>& labels,
                               const perception::ObjectSegment& segment, int label,
                               const std::optional<perception::FloorPlane>& floor, double margin) {
  perception::SegmentView view =
      perception::SegmentWindow(frame.depth_m, frame.intrinsics, labels, segment, label, margin);
  view.floor = floor;
  return view;
}

grasp::OccupancyShape ShapeOfMesh(const TriangleMesh& mesh_O, const Pose& X_WO, int cells) {
  constexpr int kFreeCells = 3;  // on each side of the mesh
  const Bounds bounds = MeshBounds(mesh_O);
  grasp::OccupancyShape shape;
  shape.size = cells;
  shape.cell_m = bounds.size().maxCoeff() / (cells - 2 * kFreeCells);
  const Vector3d corner_O = bounds.center() - Vector3d::Constant(0.5 * cells * shape.cell_m);
  shape.X_WV = X_WO * Translation(corner_O);
  shape.occupancy.assign(static_cast<size_t>(cells) * cells * cells, 0);
  const MeshQuery query(mesh_O);
  // Lines through centers of cells would pass through the edges of many meshes.
  const Vector3d offset_V = 1e-3 * shape.cell_m * Vector3d(0.37, 0.61, 0);
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const Vector3d start_O = corner_O + shape.Center_V(x, y, 0) + offset_V;
      const std::vector<SurfaceHit> hits = query.AllHits(start_O, Vector3d::UnitZ());
      for (size_t i = 0; i + 1 < hits.size(); i += 2) {
        const int first = static_cast<int>(std::ceil(hits[i].distance / shape.cell_m));
        const int last = static_cast<int>(std::floor(hits[i + 1].distance / shape.cell_m));
        for (int z = std::max(0, first); z <= std::min(cells - 1, last); ++z) {
          shape.occupancy[(static_cast<size_t>(z) * cells + y) * cells + x] = 1;
        }
      }
    }
  }
  return shape;
}

SegmentShapes::SegmentShapes(const std::string& segmentation, const std::string& completion)
    : options_(perception::SegmenterNamed(segmentation).options()),
      is_true_(completion == kTrueShapes),
      completer_(CompleterFor(completion)) {}

std::optional<grasp::OccupancyShape> SegmentShapes::ShapeOf(
    const grasp::PlannerInput& input, int label, std::vector<int>& used_instances) const {
  if (is_true_) {
    const InstanceId instance = InstanceOf(segments_.labels, label, truth_->ids);
    const bool is_used =
        std::find(used_instances.begin(), used_instances.end(), instance) != used_instances.end();
    const auto posed =
        std::find_if(truth_->scene.objects.begin(), truth_->scene.objects.end(),
                     [&](const PosedObject& candidate) { return candidate.instance == instance; });
    if (is_used || posed == truth_->scene.objects.end()) return std::nullopt;
    used_instances.push_back(instance);
    return ShapeOfMesh(truth_->objects[posed->object]->mesh_O, posed->X_WO);
  }
  const perception::SegmentView view =
      ViewOf(input.frame, segments_.labels, segments_.segments[label - 1], label,
             FloorOf(BackgroundOf(input)));
  if (perception::SegmentPixels(view) < perception::kMinSegmentPixels) return std::nullopt;
  perception::CompletedVolume volume;
  try {
    volume = completer_->Complete(view);
  } catch (const InputError&) {
    return std::nullopt;  // its readings have no extent; the other segments can be grasped
  }
  grasp::OccupancyShape shape;
  shape.X_WV = input.X_WC * Translation(volume.origin_C.cast<double>());
  shape.cell_m = volume.cell_m;
  shape.size = volume.size;
  shape.occupancy = std::move(volume.occupancy);
  return shape;
}

std::vector<grasp::OccupancyShape> SegmentShapes::Shapes(const grasp::PlannerInput& input,
                                                         int max_shapes) {
  CheckInput(!is_true_ || truth_ != nullptr,
             "planner.completion: truth needs the ground truth of the image, which only simulated "
             "trials have; choose another method");
  segments_ = perception::SegmentFrame(input.frame, BackgroundOf(input), options_);
  covered_ = perception::CoveredShares(input.frame.depth_m, segments_);
  const Pose X_BW = input.bin ? input.bin->X_WB.inverse() : Pose::Identity();
  const Pose X_BC = X_BW * input.X_WC;
  std::vector<std::pair<double, int>> by_height;  // negative height, label
  for (size_t i = 0; i < segments_.segments.size(); ++i) {
    const Vector3d center_C = segments_.segments[i].center_C.cast<double>();
    by_height.emplace_back(-(X_BC * center_C).z(), static_cast<int>(i) + 1);
  }
  std::sort(by_height.begin(), by_height.end());
  std::vector<grasp::OccupancyShape> shapes;
  std::vector<int> used_instances;
  without_shape_ = 0;
  for (const auto& [height, label] : by_height) {
    if (static_cast<int>(shapes.size()) >= max_shapes) break;
    std::optional<grasp::OccupancyShape> shape = ShapeOf(input, label, used_instances);
    if (shape) {
      shapes.push_back(std::move(*shape));
    } else {
      ++without_shape_;
    }
  }
  return shapes;
}

grasp::ImageSegments SegmentShapes::Segments() const {
  grasp::ImageSegments image{segments_.labels, {}, without_shape_};
  for (size_t i = 0; i < segments_.segments.size(); ++i) {
    image.segments.push_back({covered_[i], segments_.segments[i].center_C.cast<double>()});
  }
  return image;
}

}  // namespace pickbed::eval
