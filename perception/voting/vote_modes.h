#pragma once

// Filters the votes for an object's pose to modes, as in Kehl et al., ECCV 2016, section 3.3. Votes
// from distant descriptors are dropped; the others have weight exp(-descriptor distance). Votes are
// sorted into cells by the position of the object's center of mass. From each local maximum of the
// cell weight, a mean shift with a flat kernel finds the position. Another mean shift, among the
// votes there, finds the rotations. A mode is the mean pose of its votes.
//
// The paper uses image cells of 5 x 5 px; here the cells are cubes, which do not depend on the
// camera. The kernels of the paper are 2.5 cm and 7 degrees. Rotations that differ by a symmetry of
// the object count as equal.

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "perception/layer.h"
#include "scenes/base/settings.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

struct ModeOptions {
  double max_distance = 1.0;        // maximum descriptor distance of a vote
  double cell_diameters = 0.1;      // side of a cell, in diameters
  double center_diameters = 0.125;  // kernel radius for positions, in diameters
  double rotation_rad = 0.25;       // kernel radius for rotations
  double min_weight = 1.0;          // minimum total weight of the votes of a mode
  int rotations = 6;                // maximum number of rotation modes at one position
  void Visit(SettingsVisitor& v);
};

// A vote of one codebook entry.
struct CastVote {
  Pose X_CO = Pose::Identity();
  float distance = 0;  // descriptor distance
};

// Mean pose of votes that agree.
struct VoteMode {
  Pose X_CO = Pose::Identity();
  double weight = 0;  // total weight of its votes
  int votes = 0;
};

// Compares rotations of an object modulo its symmetries.
class ObjectRotations {
 public:
  explicit ObjectRotations(const SymmetrySet& symmetries);

  // Returns the rotation symmetric to q that is nearest to `reference`, in the same hemisphere.
  Eigen::Quaterniond Nearest(const Eigen::Quaterniond& q,
                             const Eigen::Quaterniond& reference) const;
  // Returns the angle between two rotations in rad, the minimum over the symmetries.
  double Angle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) const;

 private:
  std::vector<Eigen::Quaterniond> symmetries_O_;
};

// Returns the rotation with the smallest weighted sum of squared chordal distances (Markley et al.
// 2007, eq. 13). q and -q are equivalent. Throws std::logic_error if `rotations` is empty.
Eigen::Quaterniond MeanRotation(std::span<const Eigen::Quaterniond> rotations,
                                std::span<const double> weights);

// Returns the modes by decreasing weight. The order of the votes matters only for equal weights.
// Throws InputError for an object without a diameter.
std::vector<VoteMode> FindVoteModes(const ObjectModel& model, const ObjectRotations& rotations,
                                    const std::vector<CastVote>& votes, const ModeOptions& options);

}  // namespace pickbed::perception
