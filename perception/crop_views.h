#pragma once

// Views of parts as crops: the templates that are looked up, the further views that are learned
// from, and views apart from both to test with.
//
// Viewing directions are the corners of a subdivided icosahedron (Hinterstoisser et al., ACCV 2012;
// Wohlhart and Lepetit, CVPR 2015), on the half sphere about the part's z axis or on all of it. The
// camera is turned from the pole to the direction by the shortest arc, so that near directions give
// near orientations, at the pole too. The part's centre (of its bounding box) lies on the optical
// axis, at a distance in proportion to its diameter.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "perception/crop.h"
#include "scenes/labelled_view.h"
#include "scenes/random.h"
#include "scenes/settings.h"

namespace pickbed {

struct CropViewOptions {
  int template_level = 3;         // subdivisions of the icosahedron, 0..5: 3 = 642 directions
  int train_level = 4;            // of the views that are learned from besides: 4 = 2,562
  bool full_sphere = false;       // false: the half sphere about z, as in the paper
  int in_plane = 1;               // turns of the camera about its axis for each direction, 1..72
  double in_plane_max_rad = 0.8;  // they lie evenly between minus and plus this angle
  double side_diameters = 1.1;    // of a crop, over the part's diameter
  double distance_diameters = 9;  // camera to the part's centre, over the part's diameter
  double focal_px = 680;          //
  double apart_rad = 0.0175;      // least angle from a test view to any other view
  void Visit(SettingsVisitor& v);
};

// Corners of an icosahedron whose faces are cut in four `level` times: 10 * 4^level + 2 unit
// vectors, those of the level before first.
std::vector<Eigen::Vector3d> IcosahedronDirections(int level);

// R_CO of a camera that looks at the part from this direction in O, turned about its axis.
Eigen::Matrix3d RotationOfView(const Eigen::Vector3d& direction_O, double in_plane_rad);

using Rotations = std::vector<Eigen::Matrix3d>;  // R_CO

Rotations TemplateRotations(const CropViewOptions& options);
// Of train_level, without those of template_level.
Rotations TrainingRotations(const CropViewOptions& options);
// Random directions, and random in-plane angles where there are several turns, each at least
// apart_rad from the directions of both levels.
Rotations TestRotations(int count, const CropViewOptions& options, Rng& rng);

double CropSide_m(const ObjectModel& object, const CropViewOptions& options);
Eigen::Vector3d CropCenter_O(const ObjectModel& object);
// The camera that a part is seen by, somewhat wider than its crop (and `wider` times that), and the
// part's pose in it.
CameraIntrinsics CropCamera(const CropViewOptions& options, double wider = 1);
Pose CropPose(const ObjectModel& object, const Eigen::Matrix3d& R_CO,
              const CropViewOptions& options);

// Crops of one part with its orientation in each.
struct ObjectCrops {
  int object = 0;  // index into the source's ObjectSet
  Rotations R_CO;
  CropSet crops;  // with masks
};

// Calls take(view) for the part alone at each of these orientations in turn, see CropPose().
void ForEachCropView(LabelledViewSource& views, int object, const Rotations& R_CO,
                     const CropViewOptions& options, uint64_t seed,
                     const std::function<void(const LabelledView& view)>& take);

ObjectCrops RenderCrops(LabelledViewSource& views, int object, const Rotations& R_CO,
                        const CropViewOptions& options, uint64_t seed);

}  // namespace pickbed
