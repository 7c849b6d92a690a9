#include "eval/export/scene_glb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "eval/draw/outline.h"
#include "eval/draw/overlay.h"
#include "scenes/base/ids_format.h"
#include "scenes/camera/depth_points.h"
#include "scenes/geometry/mesh_levels.h"

namespace pickbed::eval {
namespace {

constexpr Rgb8 kTruth{205, 205, 210}, kBin{140, 150, 165}, kHand{60, 66, 76};

Eigen::Vector3f ToUnit(const Rgb8& c) { return {c.r / 255.f, c.g / 255.f, c.b / 255.f}; }

Eigen::Vector4f WithAlpha(const Rgb8& c, double alpha) {
  return {c.r / 255.f, c.g / 255.f, c.b / 255.f, static_cast<float>(alpha)};
}

// Colors that neighbours in the list do not share.
Rgb8 SegmentColor(size_t segment) {
  constexpr std::array<Rgb8, 8> kColors{{{86, 180, 233},
                                         {230, 159, 0},
                                         {0, 158, 115},
                                         {204, 121, 167},
                                         {240, 228, 66},
                                         {0, 114, 178},
                                         {213, 94, 0},
                                         {150, 150, 200}}};
  return kColors[segment % kColors.size()];
}

struct SegmentSurfaces {
  TriangleMesh completed, possible;
};

std::vector<SegmentSurfaces> SurfacesOf(const std::vector<grasp::OccupancyShape>& shapes,
                                        const SceneGlbOptions& options) {
  std::vector<SegmentSurfaces> surfaces;
  for (const grasp::OccupancyShape& shape : shapes) {
    surfaces.push_back({grasp::SurfaceOf(shape, options.completed_level),
                        grasp::SurfaceOf(shape, options.possible_level)});
  }
  return surfaces;
}

}  // namespace

const TriangleMesh& ShownMeshes::Of(ObjectId object) {
  const TriangleMesh& whole = objects_[object]->mesh_O;
  if (max_faces_ == 0 || static_cast<int>(whole.triangles.size()) <= max_faces_) return whole;
  const auto [known, is_new] = coarse_.try_emplace(object);
  if (!is_new) return known->second;
  std::vector<MeshLevel> levels = MakeMeshLevels(whole);
  const auto level = std::find_if(levels.begin(), levels.end() - 1, [&](const MeshLevel& l) {
    return static_cast<int>(l.mesh.triangles.size()) <= max_faces_;
  });
  return known->second = std::move(level->mesh);
}

std::string SceneGlb(const SceneGlbInput& input, const SceneGlbOptions& options) {
  ShownMeshes meshes(input.objects, options.max_faces);
  const ObjectSet& true_objects = input.true_objects ? *input.true_objects : input.objects;
  ShownMeshes true_meshes(true_objects, options.max_faces);
  const auto true_mesh = [&](ObjectId object) {
    const bool is_nominal = true_objects[object] == input.objects[object];
    return &(is_nominal ? meshes : true_meshes).Of(object);
  };
  const TriangleMesh bin = BinMesh(input.scene.bin);
  std::vector<GlbPart> glb_parts;
  glb_parts.push_back({"bin", &bin, Pose::Identity(), WithAlpha(kBin, options.bin_alpha)});
  for (const PosedObject& posed : input.scene.objects) {
    glb_parts.push_back(
        {fmt::format("truth {} {}", posed.instance, input.objects[posed.object]->name),
         true_mesh(posed.object), posed.X_WO, WithAlpha(kTruth, 1)});
  }
  for (size_t i = 0; i < input.hypotheses.size(); ++i) {
    const HypothesisRecord& estimated = input.hypotheses[i];
    glb_parts.push_back({fmt::format("hypothesis {} {} {:.2f}", i,
                                     input.objects[estimated.object]->name, estimated.score),
                         &meshes.Of(estimated.object), estimated.X_WO,
                         WithAlpha(ScoreColor(estimated.score), options.hypothesis_alpha)});
  }
  TriangleMesh hand;
  if (input.grasp != nullptr) {
    hand = BoxesMesh(input.gripper->Boxes(input.grasp->width_m));
    glb_parts.push_back({"hand", &hand, input.grasp->X_WG, WithAlpha(kHand, options.hand_alpha)});
  }
  const std::vector<SegmentSurfaces> surfaces = SurfacesOf(input.completed, options);
  for (size_t i = 0; i < surfaces.size(); ++i) {
    const Pose& X_WV = input.completed[i].X_WV;
    if (!surfaces[i].completed.triangles.empty()) {
      glb_parts.push_back({fmt::format("completed {}", i), &surfaces[i].completed, X_WV,
                           WithAlpha(SegmentColor(i), 1)});
    }
    if (!surfaces[i].possible.triangles.empty()) {
      glb_parts.push_back({fmt::format("possible {}", i), &surfaces[i].possible, X_WV,
                           WithAlpha(SegmentColor(i), options.possible_alpha)});
    }
  }
  const bool has_cloud = input.cloud != nullptr && !input.cloud->points_W.empty();
  return GlbBytes(glb_parts, {input.cloud, has_cloud ? 1u : 0u});
}

GlbCloud ObservedCloud(const RgbdFrame& frame, const Pose& X_WC, int stride_px) {
  constexpr Rgb8 kGrey{170, 170, 170};
  GlbCloud cloud{"cloud", {}, {}};
  const auto add = [&](int u, int v, const Eigen::Vector3d& p_C) {
    const Eigen::Vector3d p_W = X_WC * p_C;
    cloud.points_W.push_back(p_W.cast<float>());
    cloud.rgb.push_back(ToUnit(frame.color.empty() ? kGrey : frame.color(u, v)));
  };
  ForEachDepthPoint(frame.intrinsics, frame.depth_m, add, stride_px);
  return cloud;
}

GlbCloud EstimatedCloud(const ObjectSet& objects, const std::vector<HypothesisRecord>& hypotheses,
                        int points_per_object) {
  GlbCloud cloud{"hypotheses", {}, {}};
  for (const HypothesisRecord& estimated : hypotheses) {
    const ObjectModel& model = *objects[estimated.object];
    Rng rng(model.mesh_hash);
    for (const Eigen::Vector3d& p_O : SampleSurface(model.mesh_O, points_per_object, rng).points) {
      cloud.points_W.push_back((estimated.X_WO * p_O).cast<float>());
      cloud.rgb.push_back(ToUnit(ScoreColor(estimated.score)));
    }
  }
  return cloud;
}

}  // namespace pickbed::eval
