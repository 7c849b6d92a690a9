#include "eval/estimate/image_poses.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace pickbed::eval {

ResultColumns ImagePosesKeys() {
  return {
      {"image", "color image, or depth image or cloud without color, as given"},
      {"depth", "depth image or cloud, as given; empty if there is only one file"},
      {"camera.width", "width of the image", "px"},
      {"camera.height", "height of the image", "px"},
      {"camera.fx", "focal length along the columns", "px"},
      {"camera.fy", "focal length along the rows", "px"},
      {"camera.cx", "column of the principal point; 0 is the center of the first pixel", "px"},
      {"camera.cy", "row of the principal point; 0 is the center of the first pixel", "px"},
      {"depth_scale_mm", "length of one unit of the depth file"},
      {"estimator", "name and search mode of the estimator"},
      {"model", "model of the estimator, as given; empty = the included one, or none"},
      {"min_score", "minimum score of a reported pose", "0..1"},
      {"refiner", "final refiner"},
      {"seed", "random seed"},
      {"region", "region of interest, as given; empty = the whole image"},
      {"warnings", "doubts about the image, one text each"},
      {"poses[].object", "name of the object"},
      {"poses[].score", "estimated probability that the pose is right", "0..1"},
      {"poses[].R", "rotation from the object frame to the camera frame, 3 x 3, by rows"},
      {"poses[].t_m", "origin of the object frame in the camera frame: x right, y down, z forward"},
  };
}

std::string ImagePosesJson(const ImageFacts& facts, std::span<const PoseHypothesis> poses,
                           const ObjectSet& objects) {
  nlohmann::ordered_json json;
  json["image"] = facts.image;
  json["depth"] = facts.depth;
  const CameraIntrinsics& k = facts.intrinsics;
  json["camera"] = {{"width", k.width()}, {"height", k.height()}, {"fx", k.fx()},
                    {"fy", k.fy()},       {"cx", k.cx()},         {"cy", k.cy()}};
  json["depth_scale_mm"] = facts.depth_scale_mm;
  json["estimator"] = facts.estimator;
  json["model"] = facts.model;
  json["min_score"] = facts.min_score;
  json["refiner"] = facts.refiner;
  json["seed"] = facts.seed;
  json["region"] = facts.region;
  json["warnings"] = facts.warnings;
  json["poses"] = nlohmann::ordered_json::array();
  for (const PoseHypothesis& pose : poses) {
    nlohmann::ordered_json entry;
    entry["object"] = objects[pose.object]->name;
    entry["score"] = pose.score;
    for (int row = 0; row < 3; ++row) {
      const Eigen::RowVector3d r = pose.X_CO.linear().row(row);
      entry["R"].push_back({r.x(), r.y(), r.z()});
    }
    const Eigen::Vector3d t = pose.X_CO.translation();
    entry["t_m"] = {t.x(), t.y(), t.z()};
    json["poses"].push_back(std::move(entry));
  }
  return json.dump(1) + "\n";
}

ResultColumns ImagePosesColumns() {
  ResultColumns columns{{"object", "name of the object"},
                        {"score", "estimated probability that the pose is right", "0..1"}};
  for (const char row : {'1', '2', '3'}) {
    for (const char column : {'1', '2', '3'}) {
      columns.push_back({fmt::format("r{}{}", row, column),
                         fmt::format("row {}, column {} of the rotation matrix from the object "
                                     "frame to the camera frame",
                                     row, column)});
    }
  }
  for (const char axis : {'x', 'y', 'z'}) {
    columns.push_back({fmt::format("t{}_m", axis),
                       fmt::format("origin of the object frame in the camera frame: {}", axis)});
  }
  return columns;
}

std::string ImagePosesCsv(std::span<const PoseHypothesis> poses, const ObjectSet& objects) {
  std::string csv = HeaderLine(ImagePosesColumns());
  for (const PoseHypothesis& pose : poses) {
    csv += fmt::format("{},{}", objects[pose.object]->name, pose.score);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        csv += fmt::format(",{:.9g}", pose.X_CO(row, column) + 0.0);  // no "-0"
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      csv += fmt::format(",{:.9g}", pose.X_CO.translation()[axis] + 0.0);
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace pickbed::eval
