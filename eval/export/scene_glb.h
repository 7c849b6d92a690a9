#pragma once

// An attempt as a scene for 3D viewers: true instances, estimated poses, hand at the grasp, and
// observed point cloud.

#include <map>
#include <string>
#include <vector>

#include "eval/trial/trial.h"
#include "grasp/completed/occupancy_shape.h"
#include "grasp/gripper.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/mesh_io/scene_export.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// Object meshes for a file: with at most `max_faces` faces, if there is such a level (see
// scenes/geometry/mesh_levels.h); 0 = all faces. Keeps a reference to the objects.
class ShownMeshes {
 public:
  ShownMeshes(const ObjectSet& objects, int max_faces) : objects_(objects), max_faces_(max_faces) {}
  // The reference is valid as long as this object and the objects.
  const TriangleMesh& Of(ObjectId object);

 private:
  const ObjectSet& objects_;
  int max_faces_;
  std::map<int, TriangleMesh> coarse_;
};

// Content of the scene.
struct SceneGlbInput {
  const Scene& scene;  // true poses
  const ObjectSet& objects;
  const std::vector<HypothesisRecord>& hypotheses;  // only object, pose and score are used
  const Grasp* grasp = nullptr;                     // may be null
  const Gripper* gripper = nullptr;                 // not null if there is a grasp
  const GlbCloud* cloud = nullptr;                  // may be null
  const ObjectSet* true_objects = nullptr;  // of the scene, in their true sizes; null = `objects`
  // Completed segments of the image.
  std::vector<grasp::OccupancyShape> completed = {};
};

// Options of SceneGlb.
struct SceneGlbOptions {
  // Meshes with more faces are replaced by a coarser level, see scenes/geometry/mesh_levels.h; 0 =
  // never.
  int max_faces = 0;
  double hypothesis_alpha = 0.5;  // opacity, 0..1
  double bin_alpha = 0.3;
  double hand_alpha = 0.8;
  // Surface level and possible-matter level of completed segments.
  double completed_level = grasp::kSurfaceLevel;
  double possible_level = grasp::kPossibleLevel;
  double possible_alpha = 0.25;
};

// Returns the bytes of a GLB file. Nodes: "bin", "truth INSTANCE OBJECT", "hypothesis RANK OBJECT
// SCORE", "hand", "completed SEGMENT", "possible SEGMENT", and the name of the cloud. Hypotheses
// are colored by their score, see ScoreColor() in eval/draw/overlay.h.
std::string SceneGlb(const SceneGlbInput& input, const SceneGlbOptions& options = {});

// Returns the observed points of every stride_px-th column and row in frame W, with the image
// colors (gray if the frame has none).
GlbCloud ObservedCloud(const RgbdFrame& frame, const Pose& X_WC, int stride_px);

// Returns uniform surface samples of each hypothesis at its estimated pose in frame W, colored by
// score. Deterministic.
GlbCloud EstimatedCloud(const ObjectSet& objects, const std::vector<HypothesisRecord>& hypotheses,
                        int points_per_object);

}  // namespace pickbed::eval
