#pragma once

// Votes for a part's pose filtered to modes, as in Kehl et al., ECCV 2016, section 3.3: votes of
// far neighbours are not cast; those that are weigh exp(-distance of the descriptors) and are
// thrown into cells by the place of the part's middle; from each local maximum of the cells' weight
// a mean shift with a flat kernel finds the middle, and among its votes another the rotations. What
// comes out is the mean pose of the votes that agree. The paper counts in cells of the image, 5 x 5
// px; here the cells are cubes, which do not depend on the camera. Its kernels are 2.5 cm and 7
// degrees.
//
// All rotations that a symmetry of the part makes one count as one.

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "scenes/object_model.h"
#include "scenes/settings.h"

namespace pickbed {

struct ModeOptions {
  double max_distance = 1.0;        // of descriptors; farther neighbours cast no vote
  double cell_diameters = 0.1;      // side of a cell
  double middle_diameters = 0.125;  // radius of the kernel of middles
  double rotation_rad = 0.25;       // radius of the kernel of rotations
  double min_weight = 1.0;          // of a mode's votes together
  int rotations = 6;                // modes of rotation at one middle at most
  void Visit(SettingsVisitor& v);
};

struct CastVote {
  Pose X_CO = Pose::Identity();
  float distance = 0;  // of the descriptors
};

struct VoteMode {
  Pose X_CO = Pose::Identity();
  double weight = 0;  // of its votes together
  int votes = 0;
};

// Rotations of a part, all symmetric ones as one.
class PartRotations {
 public:
  explicit PartRotations(const SymmetrySet& symmetries);

  // The one of q's symmetric rotations that is nearest to `reference`, in its hemisphere.
  Eigen::Quaterniond Nearest(const Eigen::Quaterniond& q,
                             const Eigen::Quaterniond& reference) const;
  // Angle between two, least over the symmetries, rad.
  double Angle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) const;

 private:
  std::vector<Eigen::Quaterniond> symmetries_O_;
};

// The rotation with the least weighted sum of squared chords to the others (Markley et al. 2007,
// eq. 13): q and -q are one. Throws std::logic_error for none.
Eigen::Quaterniond MeanRotation(std::span<const Eigen::Quaterniond> rotations,
                                std::span<const double> weights);

// Heaviest first. The order of the votes does not matter but for equal weights.
std::vector<VoteMode> FindVoteModes(const ObjectModel& model, const PartRotations& rotations,
                                    const std::vector<CastVote>& votes, const ModeOptions& options);

}  // namespace pickbed
