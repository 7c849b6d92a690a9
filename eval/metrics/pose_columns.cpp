#include "eval/metrics/pose_columns.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

namespace pickbed::eval {

ResultColumns PoseColumns(const std::string& what) {
  const std::string rotation =
      what + ", rotation from the object frame to the world frame: unit quaternion, ";
  const std::string position = what + ", origin of the object frame in the world frame: ";
  return {{"qw", rotation + "w, not negative"},
          {"qx", rotation + "x"},
          {"qy", rotation + "y"},
          {"qz", rotation + "z"},
          {"tx_m", position + "x"},
          {"ty_m", position + "y"},
          {"tz_m", position + "z"}};
}

std::string PoseCells(const scenes::Pose& X_WO) {
  Eigen::Quaterniond q(X_WO.linear());
  if (q.w() < 0) q.coeffs() *= -1;
  const Eigen::Vector3d t = X_WO.translation();
  std::string cells;
  for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
    cells += fmt::format(",{:.9g}", value + 0.0);  // no "-0"
  }
  return cells;
}

std::string EmptyPoseCells() { return std::string(PoseColumns("").size(), ','); }

}  // namespace pickbed::eval
