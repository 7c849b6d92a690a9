#pragma once

// Files of grasps of an object: isaac_grasp YAML 1.0 (NVIDIA Isaac Sim), and the CSV of `pickbed
// grasps`. docs/pages/guides/grasp_files.md describes both.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/grasps/gripper_frame.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// A grasp of a file.
struct FileGrasp {
  std::string name;
  Pose X_OF = Pose::Identity();  // pose of the hand; F is the frame of its program
  double confidence = 1;
  std::optional<double> width_m;  // distance between the contacts; none: not given
  std::string place = {};         // file and line, for messages
};

// Content of a file.
struct GraspFile {
  std::string file;         // path, for messages
  std::string object_file;  // empty: not given
  std::string gripper_file;
  std::optional<int> approach_axis;  // 0 = x, 1 = y, 2 = z of F
  std::vector<FileGrasp> grasps;     // at least one
};

// Reads a file that ends in .yaml or .yml (isaac_grasp), or in .csv. Throws InputError for another
// format or version, a missing key, a number that is not finite, an orientation that is no unit
// quaternion, a confidence outside of 0 to 1, an object_scale other than 1, and a file without
// grasps.
GraspFile ReadGraspFile(const std::filesystem::path& file);

// Throws InputError if the file names another object or gripper, or another approach axis than
// `frame`, if a hand is over 1 m away from the object, or if a grasp is wider than the gripper
// opens. A file that names none is accepted. `names_matter`: whether object and gripper are
// compared.
void RequireGraspsOf(const GraspFile& file, const ObjectModel& object, const Gripper& gripper,
                     const GripperFrame& frame, bool names_matter = true);

// Returns the grasps as candidates, in the same order. Width and depth of the contact are measured
// on the mesh if the file does not give a width. Quality is 1, since the file's grasps are not to
// be rejected; robust is the confidence.
std::vector<GraspCandidate> CandidatesOf(const GraspFile& file, const ObjectModel& object,
                                         const Gripper& gripper, const GripperFrame& frame);

// Returns the candidates as isaac_grasp YAML. The confidence is GraspCandidate::robust. The joints
// left_finger and right_finger are the distances of the pads from the center of the hand.
std::string IsaacGraspText(const std::string& object_file, const Gripper& gripper,
                           const GripperFrame& frame,
                           const std::vector<GraspCandidate>& candidates);

// Throws InputError if `file` has no extension of WriteGraspFile(), or is a CSV in another frame
// than frame G.
void RequireGraspFormat(const std::filesystem::path& file, const GripperFrame& frame);

// Writes the candidates in the format of the extension: .yaml, .yml or .csv. A YAML file names the
// mesh OBJECT.obj beside it, which is written unless it exists. Throws as RequireGraspFormat().
void WriteGraspFile(const std::filesystem::path& file, const ObjectModel& object,
                    const Gripper& gripper, const GripperFrame& frame,
                    const std::vector<GraspCandidate>& candidates);

}  // namespace pickbed::eval
