#include "eval/grasps/grasp_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "eval/export/grasps_csv.h"
#include "eval/grasps/isaac_grasp.h"
#include "eval/stats/statistics.h"
#include "grasp/grippers/requirements.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/geometry/triangle_mesh.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::eval {
namespace {

std::vector<std::string> Cells(std::string line) {
  if (line.ends_with('\r')) line.pop_back();
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  if (line.ends_with(',')) cells.emplace_back();
  return cells;
}

void RequireUtf8(const std::string& line, const std::string& place) {
  CheckInput(IsUtf8(line), fmt::format("{}: '{}' is not UTF-8; save the file as UTF-8", place,
                                       Printable(OneLine(line))));
}

double NumberIn(const std::string& cell, const std::string& column, const std::string& place) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  CheckInput(error == std::errc() && end == cell.data() + cell.size() && std::isfinite(value),
             fmt::format("{}: {} = '{}': must be a finite number", place, column, cell));
  constexpr double kSmallest = 1e-100;  // rounding of a zero gives larger numbers
  CheckInput(
      value == 0 || std::abs(value) > kSmallest || column == "confidence" || column == "robust",
      fmt::format("{}: {} = '{}': is too small for a length or a share; get the file again", place,
                  column, cell));
  return value;
}

// Reads the CSV of `pickbed grasps`. Columns may have any order; the confidence is the column
// `confidence` or, without it, `robust`.
GraspFile ReadGraspsCsv(const std::string& text, const std::string& name) {
  constexpr double kMaxError = 1e-3;
  CheckInput(!text.ends_with('.'),
             fmt::format("{}: ends within a number, so it is cut short", name));
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  RequireUtf8(line, name + ":1");
  std::map<std::string, size_t> columns;
  const std::vector<std::string> header = Cells(line);
  for (size_t i = 0; i < header.size(); ++i) columns[header[i]] = i;
  GraspFile file;
  file.file = name;
  for (int number = 2; std::getline(lines, line); ++number) {
    if (line.empty() || line == "\r") continue;
    const std::string place = fmt::format("{}:{}", name, number);
    RequireUtf8(line, place);
    const std::vector<std::string> cells = Cells(line);
    CheckInput(cells.size() == header.size(),
               fmt::format("{}: has {} columns, but the first line has {}", place, cells.size(),
                           header.size()));
    const auto number_of = [&](const std::string& column) {
      const auto found = columns.find(column);
      CheckInput(found != columns.end(),
                 fmt::format("{}: has no column {}; r00 to r22 are the rotation and x_m, y_m, z_m "
                             "the position of the hand in the object frame",
                             name, column));
      return NumberIn(cells[found->second], column, place);
    };
    Eigen::Matrix3d R;
    for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = number_of(fmt::format("r{}{}", i / 3, i % 3));
    const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    CheckInput(error < kMaxError && R.determinant() > 0,
               fmt::format("{}: r00 to r22 are no rotation: R^T R differs from the identity by "
                           "{:.2g}, and its determinant is {:.3g}",
                           place, error, R.determinant()));
    FileGrasp& grasp = file.grasps.emplace_back();
    grasp.place = place;
    grasp.name = columns.contains("name") ? cells[columns["name"]]
                                          : fmt::format("grasp_{}", file.grasps.size() - 1);
    grasp.X_OF = MakePose(R, {number_of("x_m"), number_of("y_m"), number_of("z_m")});
    for (const char* column : {"robust", "confidence"}) {
      if (columns.contains(column)) grasp.confidence = number_of(column);
    }
    // Columns of the files of this program that are not used. Those of others may be empty.
    for (const char* column : {"depth_m", "quality", "epsilon"}) {
      if (columns.contains(column) && !cells[columns[column]].empty()) number_of(column);
    }
    if (columns.contains("width_m")) grasp.width_m = std::max(0.0, number_of("width_m"));
  }
  CheckInput(!file.grasps.empty(), fmt::format("{}: has no grasps", name));
  return file;
}

enum class GraspFormat { kIsaac, kCsv };

GraspFormat FormatOf(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".yaml" || extension == ".yml") return GraspFormat::kIsaac;
  CheckInput(
      extension == ".csv",
      fmt::format("{}: a file of grasps ends in .yaml (isaac_grasp) or .csv", file.string()));
  return GraspFormat::kCsv;
}

// Whether a path names an object or gripper: its stem, or the folder of a file such as mesh.obj.
bool Names(const std::filesystem::path& path, const std::string& name) {
  return path.empty() || path.stem() == name || path.parent_path().filename() == name;
}

// Width and depth of the mesh between the open fingers: twice the largest distance from the center
// of the hand, and the distance of its center behind the tips. Zero for a hand without fingers.
void MeasureContact(const ObjectModel& object, const Gripper& gripper, GraspCandidate& candidate) {
  const auto region = gripper.RegionBetween(gripper.MaxOpening_m());
  if (!region) return;
  const Pose X_GO = candidate.X_OG.inverse();
  double half_m = 0, low_z_m = kInfinity, high_z_m = -kInfinity;
  constexpr int kPerEdge = 8;  // points along each edge of a triangle
  for (const auto& triangle : object.mesh_O.triangles) {
    const Eigen::Vector3d a = X_GO * object.mesh_O.vertices[triangle[0]];
    const Eigen::Vector3d b = X_GO * object.mesh_O.vertices[triangle[1]];
    const Eigen::Vector3d c = X_GO * object.mesh_O.vertices[triangle[2]];
    for (int i = 0; i <= kPerEdge; ++i) {
      for (int j = 0; i + j <= kPerEdge; ++j) {
        const double u = static_cast<double>(i) / kPerEdge, v = static_cast<double>(j) / kPerEdge;
        const Eigen::Vector3d p_G = (1 - u - v) * a + u * b + v * c;
        if (((p_G - region->center).cwiseAbs().array() > region->half_size.array()).any()) continue;
        half_m = std::max(half_m, std::abs(p_G.x()));
        low_z_m = std::min(low_z_m, p_G.z());
        high_z_m = std::max(high_z_m, p_G.z());
      }
    }
  }
  if (candidate.width_m == 0) candidate.width_m = 2 * half_m;
  if (low_z_m <= high_z_m) candidate.depth_m = -0.5 * (low_z_m + high_z_m);
}

// Throws InputError if a hand is too far away to hold the object, as if positions were in
// millimetres.
void RequireNear(const GraspFile& file, const ObjectModel& object) {
  constexpr double kMaxHand_m = 1;  // from the frame of a hand to its fingertips
  const Eigen::Vector3d center_O = MeshBounds(object.mesh_O).center();
  for (const FileGrasp& grasp : file.grasps) {
    const double distance_m = (grasp.X_OF.translation() - center_O).norm();
    CheckInput(distance_m <= object.diameter_m + kMaxHand_m,
               fmt::format("{}: grasp '{}' is {:.4g} m from the object; positions are in metres",
                           file.file, grasp.name, distance_m));
  }
}

// Throws InputError for a grasp that is wider than the fingers open.
void RequireFitsOpening(const GraspFile& file, const Gripper& gripper) {
  for (const FileGrasp& grasp : file.grasps) {
    const double width_m = grasp.width_m.value_or(0);
    CheckInput(
        OpensFor(gripper, width_m),
        fmt::format("{}: grasp '{}' is {:.4g} m wide, but gripper {} opens at most {:.4g} m; "
                    "remove it, or test with a wider gripper",
                    grasp.place, grasp.name, width_m, gripper.name, gripper.MaxOpening_m()));
  }
}

}  // namespace

GraspFile ReadGraspFile(const std::filesystem::path& file) {
  const GraspFormat format = FormatOf(file);
  const std::string text = ReadFileText(file);
  GraspFile read = format == GraspFormat::kIsaac ? ReadIsaacGrasps(text, file.string())
                                                 : ReadGraspsCsv(text, file.string());
  for (const FileGrasp& grasp : read.grasps) {
    CheckInput(grasp.confidence >= 0 && grasp.confidence <= 1,
               fmt::format("{}: grasp '{}' has the confidence {:g}; it is from 0 to 1", grasp.place,
                           grasp.name, grasp.confidence));
  }
  return read;
}

void RequireGraspsOf(const GraspFile& file, const ObjectModel& object, const Gripper& gripper,
                     const GripperFrame& frame, bool names_matter) {
  CheckInput(!names_matter || Names(file.object_file, object.name),
             fmt::format("{}: is for the object {}, not {}; test it nevertheless with "
                         "ignored names",
                         file.file, file.object_file, object.name));
  CheckInput(!names_matter || Names(file.gripper_file, gripper.name),
             fmt::format("{}: is for the gripper {}, not {}; test it nevertheless with "
                         "ignored names",
                         file.file, file.gripper_file, gripper.name));
  RequireNear(file, object);
  RequireFitsOpening(file, gripper);
  if (!file.approach_axis) return;
  const std::string axis(1, "xyz"[*file.approach_axis]);
  CheckInput(axis == frame.approach,
             fmt::format("{}: its hand approaches along {}, but the gripper frame along {}; give "
                         "the frame of the file's hand",
                         file.file, axis, frame.approach));
}

std::vector<GraspCandidate> CandidatesOf(const GraspFile& file, const ObjectModel& object,
                                         const Gripper& gripper, const GripperFrame& frame) {
  const Pose X_FG = frame.X_FG();
  std::vector<GraspCandidate> candidates;
  for (const FileGrasp& grasp : file.grasps) {
    GraspCandidate& candidate = candidates.emplace_back();
    candidate.X_OG = grasp.X_OF * X_FG;
    candidate.width_m = grasp.width_m.value_or(0);
    candidate.quality = 1;
    candidate.robust = grasp.confidence;
    MeasureContact(object, gripper, candidate);
  }
  return candidates;
}

std::string IsaacGraspText(const std::string& object_file, const Gripper& gripper,
                           const GripperFrame& frame,
                           const std::vector<GraspCandidate>& candidates) {
  const Pose X_GF = frame.X_FG().inverse();
  std::string text = fmt::format(
      "format: isaac_grasp\nformat_version: 1.0\n\ncreated_with: pickbed\nobject_file: {}\n"
      "object_scale: 1.0\ngripper_file: {}.yaml\n# The fingertips are at [{}, {}, {}] m of the "
      "gripper frame; it approaches along {} and closes along {}.\n",
      object_file, gripper.name, frame.tip_m.x(), frame.tip_m.y(), frame.tip_m.z(), frame.approach,
      frame.closing);
  if (frame.approach.size() == 1) {
    text += fmt::format("approach_axis: {}\n", frame.approach.front() - 'x');
  }
  text += "\ngrasps:\n";
  const bool has_fingers = gripper.RegionBetween(gripper.MaxOpening_m()).has_value();
  for (size_t i = 0; i < candidates.size(); ++i) {
    const GraspCandidate& candidate = candidates[i];
    const Pose X_OF = candidate.X_OG * X_GF;
    const Eigen::Quaterniond q(X_OF.linear());
    const auto joints = [&](double width_m) {
      if (!has_fingers) return std::string("{}");
      return fmt::format("{{left_finger: {0}, right_finger: {0}}}", 0.5 * width_m);
    };
    const double open_m = gripper.OpeningOrMax_m(candidate.width_m);
    text += fmt::format(
        "  grasp_{}:\n    confidence: {}\n    position: [{}, {}, {}]\n"
        "    orientation: {{w: {}, xyz: [{}, {}, {}]}}\n    cspace_position: {}\n"
        "    pregrasp_cspace_position: {}\n",
        i, candidate.robust, X_OF.translation().x(), X_OF.translation().y(), X_OF.translation().z(),
        q.w(), q.x(), q.y(), q.z(), joints(candidate.width_m), joints(open_m));
  }
  return text;
}

void RequireGraspFormat(const std::filesystem::path& file, const GripperFrame& frame) {
  CheckInput(FormatOf(file) != GraspFormat::kCsv || frame.X_FG().matrix().isIdentity(),
             fmt::format("{}: a CSV of grasps is in the frame between the fingertips; write a "
                         ".yaml file for another frame",
                         file.string()));
}

void WriteGraspFile(const std::filesystem::path& file, const ObjectModel& object,
                    const Gripper& gripper, const GripperFrame& frame,
                    const std::vector<GraspCandidate>& candidates) {
  RequireGraspFormat(file, frame);
  if (FormatOf(file) == GraspFormat::kCsv) return WriteFileAtomically(file, GraspsCsv(candidates));
  const std::filesystem::path mesh = file.parent_path() / (object.name + ".obj");
  if (!std::filesystem::exists(mesh)) SaveObj(mesh, object.mesh_O);
  WriteFileAtomically(file, IsaacGraspText(mesh.filename().string(), gripper, frame, candidates));
}

}  // namespace pickbed::eval
