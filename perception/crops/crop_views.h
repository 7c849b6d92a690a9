#pragma once

// Views of objects as crops: templates for look-up, additional views for training, and test views
// that differ from both.
//
// Viewing directions are the corners of a subdivided icosahedron (Hinterstoisser et al., ACCV 2012;
// Wohlhart and Lepetit, CVPR 2015), on the upper half sphere (z >= 0 in O) or on the full sphere.
// The camera rotates from the pole to the direction along the shortest arc. Neighbouring directions
// then give neighbouring orientations, also at the pole. The center of the object's bounding box is
// on the optical axis, at a distance proportional to the diameter.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "perception/crops/crop.h"
#include "scenes/base/ids.h"
#include "scenes/base/random.h"
#include "scenes/base/settings.h"
#include "scenes/labelled_view.h"

namespace pickbed::perception {

struct CropViewOptions {
  int template_level = 3;         // subdivisions of the icosahedron, 0..5: 3 = 642 directions
  int train_level = 4;            // the same for the additional training views: 4 = 2,562
  bool full_sphere = false;       // false: upper half sphere only, as in the paper
  int in_plane = 1;               // rotations of the camera about its axis per direction, 1..72
  double in_plane_max_rad = 0.8;  // they are evenly spaced between minus and plus this angle
  double side_diameters = 1.1;    // side of a crop, in object diameters
  double distance_diameters = 9;  // camera to the object center, in object diameters
  double focal_px = 680;
  double apart_rad = 0.0175;  // minimum angle between a test view and any other view
  void Visit(SettingsVisitor& v);
};

// Returns the corners of an icosahedron whose faces are split into four, `level` times. These are
// 2 + 10 * 4^level unit vectors. The corners of a coarser level come first in a finer level.
std::vector<Eigen::Vector3d> IcosahedronDirections(int level);

// Returns R_CO for a camera in this direction from the object, rotated about its optical axis.
Eigen::Matrix3d RotationOfView(const Eigen::Vector3d& direction_O, double in_plane_rad);

using Rotations = std::vector<Eigen::Matrix3d>;  // R_CO

// Directions of template_level.
Rotations TemplateRotations(const CropViewOptions& options);
// Directions of train_level that are not in template_level.
Rotations TrainingRotations(const CropViewOptions& options);
// Random directions, at least apart_rad from the directions of both levels. In-plane angles are
// random if in_plane > 1.
Rotations TestRotations(int count, const CropViewOptions& options, Rng& rng);

// Returns the side of a crop, in m.
double CropSide_m(const ObjectModel& object, const CropViewOptions& options);
// Returns the center of the object's bounding box in O, in m.
Eigen::Vector3d CropCenter_O(const ObjectModel& object);
// Returns the camera of a crop view; its image is 1.5 * `wider` times as wide as the crop.
CameraIntrinsics CropCamera(const CropViewOptions& options, double wider = 1);
// Returns X_CO with the object center on the optical axis.
Pose CropPose(const ObjectModel& object, const Eigen::Matrix3d& R_CO,
              const CropViewOptions& options);

// Crops of one object and its orientation in each.
struct ObjectCrops {
  ObjectId object{0};  // index into the source's ObjectSet
  Rotations R_CO;
  CropSet crops;  // with masks
};

// Renders the isolated object at each orientation, see CropPose(), and calls take(view) in order.
void ForEachCropView(LabelledViewSource& views, ObjectId object, const Rotations& R_CO,
                     const CropViewOptions& options, uint64_t seed,
                     const std::function<void(const LabelledView& view)>& take);

// Renders the same views and cuts one crop per view, with its mask.
ObjectCrops RenderCrops(LabelledViewSource& views, ObjectId object, const Rotations& R_CO,
                        const CropViewOptions& options, uint64_t seed);

// Training set of a method for whole-object crops: objects, their templates and additional views.
struct CropTrainingSet {
  ObjectSet objects;
  std::vector<ObjectCrops> templates;  // per object, from an ideal sensor
  std::vector<ObjectCrops> training;   // per object: additional views, and noisy and relit ones
};

// Makes a training set for all objects. `clean` renders the templates and the views of train_level.
// `varied` renders all of these views again as training views, for example with sensor noise and
// other lamps. Both sources must have the same objects. `on_share` receives the progress, 0..1; it
// may be empty, and returns false to stop. The result is then incomplete.
CropTrainingSet MakeCropTrainingSet(LabelledViewSource& clean, LabelledViewSource& varied,
                                    const CropViewOptions& options, uint64_t seed,
                                    const std::function<bool(double share)>& on_share = {});

}  // namespace pickbed::perception
