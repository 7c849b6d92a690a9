#pragma once

// Frames of the hand in grasp files. Programs put the origin of a hand at its fingertips or at its
// base, and name its axes differently.
//
//     frame F, for example panda_hand         frame G of pickbed (grasp/gripper.h)
//
//       +-----F-----+ ---> y  closing           +-----------+
//       |     |     |                           |   palm    |
//       +-+---|---+-+                           +-+-------+-+
//         |   v z |    approach                   |       |
//         |       |                               |   G---|---> x  closing
//         |       |                               |   |   |
//                                                     v z  approach

#include <span>
#include <string>

#include "eval/layer.h"
#include "scenes/base/settings.h"
#include "scenes/geometry/pose.h"

namespace pickbed::eval {

// A frame F of a hand.
struct GripperFrame {
  std::string approach = "z";  // axis of F in the approach direction: x, -x, y, -y, z or -z
  std::string closing = "x";   // axis of F in the closing direction
  Eigen::Vector3d tip_m = Eigen::Vector3d::Zero();  // origin of G in F: between the fingertips
  void Visit(SettingsVisitor& v);

  // Returns the pose of G in F. Throws InputError if both axes are on one line.
  Pose X_FG() const;
};

// A frame with its name.
struct GripperFrameRow {
  const char* name;
  const char* help;
  GripperFrame frame;
};
// Returns the known frames; the first one is frame G of pickbed.
std::span<const GripperFrameRow> GripperFrameTable();

// Returns the frame with this name, or reads it from a path that ends in .yaml. Throws InputError
// for an unknown name and for a wrong file.
GripperFrame LoadGripperFrame(const std::string& name_or_path);

}  // namespace pickbed::eval
