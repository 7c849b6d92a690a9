#pragma once

// Where parts go before they fall: turned so that they fit, in cells of a layer or apart on the
// floor.

#include <vector>

#include "scenes/random.h"
#include "scenes/scene.h"

namespace pickbed {

struct TurnedPart {
  int object = 0;
  Eigen::Matrix3d R_WO;
  Eigen::AlignedBox3d box;  // about the origin of O, axes of W
};

// Box of a part's convex pieces about its origin in some orientation.
Eigen::AlignedBox3d TurnedBox(const ObjectModel& model, const Eigen::Matrix3d& R_WO);

// Throws InputError when the part cannot lie on the bin's floor.
void RequireFits(const ObjectModel& model, const Bin& bin);

// A random orientation in which the part fits between the walls with `clearance_m` on each side;
// after `attempts` it lies flat.
TurnedPart TurnAtRandom(const ObjectSet& objects, int object, const Bin& bin, double clearance_m,
                        int attempts, Rng& rng);

struct Cell {
  const TurnedPart* part;
  Eigen::Vector2d low;  // corner with smallest x and y, from the bin's own
};

// Fills one layer with the parts from `first` on, row by row. Returns the cells; the first part
// always gets one, so that pouring comes to an end.
std::vector<Cell> PackLayer(const std::vector<TurnedPart>& parts, size_t first, const Bin& bin,
                            double clearance_m);

// Upright parts apart from each other on the floor, largest footprint first: the box of each is
// free of all others'. Those that find no place in `attempts` are left out. Poses in W, in the
// order of `kinds`' indices that found one.
struct PlacedPart {
  int object = 0;
  Pose X_WO = Pose::Identity();
};
std::vector<PlacedPart> PlaceUpright(const ObjectSet& objects, const std::vector<int>& kinds,
                                     const Bin& bin, double clearance_m, int attempts, Rng& rng);

}  // namespace pickbed
