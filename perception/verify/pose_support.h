#pragma once

// Support of a pose by the readings: how firmly they hold it in its weakest directions, and how
// many readings continue the plane that the pose agrees with.
//
// A rod whose ends are hidden agrees with the image at every place along its axis. A cup whose rim
// is flush with a table agrees with the table. The share of agreeing pixels is high in both cases.
// But each reading on the surface holds the pose only along its normal, and each seen part of the
// outline only across the outline. The sum over the readings is the information matrix of
// point-to-plane ICP (Gelfand et al., "Geometrically Stable Sampling for the ICP Algorithm", 2003).

#include <Eigen/Core>
#include <array>
#include <vector>

namespace pickbed::perception {

struct PoseSupport {
  // Square roots of the smallest and the second smallest eigenvalue of the information matrix per
  // covered pixel. Rotations are about the center of the object and scaled by its radius, so all
  // directions have one unit. The smallest is about 0 for an object with a continuous symmetry.
  double weakest = 0, second_weakest = 0;
  double outline_seen = 0;  // share of the outline beyond which a farther surface is seen
  // Readings in front of the surface or beyond the outline that are on the plane of the agreeing
  // readings, per covered pixel, at most kMaxCoplanar; lower if few of them are on one plane.
  double coplanar = 0;
};

inline constexpr double kMaxCoplanar = 2;

// Collects the pixels of one pose. Its memory is kept for the next pose.
class PoseSupportMeasure {
 public:
  // Starts a pose of an object with this bounding ball. Readings within band_m of a plane are on
  // it.
  void Begin(const Eigen::Vector3f& center_C, float radius_m, float band_m);
  // Adds a pixel that the object covers.
  void AddCovered() { ++covered_; }
  // Adds a covered pixel with a reading on the surface, and the unit normal of the surface.
  void AddAgreeing(const Eigen::Vector3f& p_C, const Eigen::Vector3f& normal_C);
  // Adds a reading in front of the surface or beyond the outline.
  void AddOther(const Eigen::Vector3f& p_C) { others_C_.push_back(p_C); }
  // Adds an agreeing pixel at the outline. across_C is the unit vector across the outline, parallel
  // to the image; `seen` means that a farther surface is seen beyond the outline.
  void AddOutline(const Eigen::Vector3f& p_C, const Eigen::Vector3f& across_C, bool seen);
  // Returns the support; all 0 without an agreeing pixel.
  PoseSupport Finish() const;

 private:
  void Hold(const Eigen::Vector3f& p_C, const Eigen::Vector3f& direction_C);
  double CoplanarShare() const;

  Eigen::Vector3f center_C_ = Eigen::Vector3f::Zero();
  float radius_m_ = 1, band_m_ = 0;
  int covered_ = 0, outline_ = 0, outline_seen_ = 0;
  // One row per reading or seen outline pixel: the direction, arm x direction, and two zeros that
  // fill a vector of eight. The information matrix is the sum of row * row^T.
  using Row = std::array<float, 8>;
  std::vector<Row> rows_;
  std::vector<Eigen::Vector3f> agreeing_C_, normals_C_, others_C_;
};

}  // namespace pickbed::perception
