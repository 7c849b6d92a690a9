#pragma once

// A look at a bin as a scene for 3D viewers: what truly lay there, what was believed, the hand of
// the grasp and the points that the camera saw.

#include <string>
#include <vector>

#include "eval/trial.h"
#include "grasp/gripper.h"
#include "scenes/camera.h"
#include "scenes/glb_writer.h"
#include "scenes/rgbd_frame.h"
#include "scenes/scene.h"

namespace pickbed {

struct SceneGlbInput {
  const Scene& scene;  // the truth
  const ObjectSet& objects;
  const std::vector<HypothesisScore>& hypotheses;  // only part, pose and score count
  const Grasp* grasp = nullptr;                    // may be null
  const GripperSpec* gripper = nullptr;            // not null where there is a grasp
  const GlbCloud* cloud = nullptr;                 // may be null
};

struct SceneGlbOptions {
  // A mesh with more is shown by its coarser version, see scenes/mesh_levels.h; 0 = as it is.
  int most_faces = 0;
  double hypothesis_alpha = 0.5;  // opacity, 0..1
  double bin_alpha = 0.3;
  double hand_alpha = 0.8;
};

// Nodes: "bin", "truth INSTANCE PART", "hypothesis RANK PART SCORE", "hand", and the cloud's name.
// Hypotheses are red (doubtful) to green (sure), as in overlays.
std::string SceneGlb(const SceneGlbInput& input, const SceneGlbOptions& options = {});

// What the camera saw, with its colours (grey where the frame has none); every stride_px-th column
// and row.
GlbCloud ObservedCloud(const RgbdFrame& frame, const Pose& X_WC, int stride_px);

// Even samples of the surface of each hypothesis where it is believed, coloured by score; the same
// for the same input.
GlbCloud BelievedCloud(const ObjectSet& objects, const std::vector<HypothesisScore>& hypotheses,
                       int points_per_part);

}  // namespace pickbed
