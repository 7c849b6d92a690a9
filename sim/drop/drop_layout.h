#pragma once

// Initial poses of instances before they fall: rotated so that they fit, in the cells of a layer or
// apart on the floor.

#include <vector>

#include "scenes/base/ids.h"
#include "scenes/base/random.h"
#include "scenes/scene.h"
#include "sim/layer.h"

namespace pickbed::sim {

// An instance with its orientation and bounding box.
struct RotatedObject {
  ObjectId object{0};
  Eigen::Matrix3d R_WO;
  Eigen::AlignedBox3d box;  // about the origin of O, with the axes of W
};

// Returns the box of an object's convex pieces about its origin, in orientation R_WO.
Eigen::AlignedBox3d RotatedBox(const ObjectModel& model, const Eigen::Matrix3d& R_WO);

// Throws InputError if the object does not fit on the bin floor in any orientation.
void RequireFits(const ObjectModel& model, const Bin& bin);

// Returns a random orientation that fits between the walls with `clearance_m` on each side. After
// `attempts` failures, the object is laid flat.
RotatedObject TurnAtRandom(const ObjectSet& objects, ObjectId object, const Bin& bin,
                           double clearance_m, int attempts, Rng& rng);

// A place in a layer.
struct Cell {
  const RotatedObject* instance;
  Eigen::Vector2d low;  // corner with smallest x and y, relative to the bin's corner
};

// Fills one layer with instances from index `first` on, row by row. Returns their cells. The first
// instance always gets a cell, so that pouring always ends.
std::vector<Cell> PackLayer(const std::vector<RotatedObject>& instances, size_t first,
                            const Bin& bin, double clearance_m);

// An instance placed on the floor.
struct PlacedInstance {
  ObjectId object{0};
  Pose X_WO = Pose::Identity();
};
// Places upright instances apart on the floor, with disjoint bounding boxes, largest footprint
// first. `kinds` holds object indices. An instance without a free place after `attempts` is left
// out. Returns the poses in the order of placement.
std::vector<PlacedInstance> PlaceUpright(const ObjectSet& objects,
                                         const std::vector<ObjectId>& kinds, const Bin& bin,
                                         double clearance_m, int attempts, Rng& rng);

}  // namespace pickbed::sim
