#pragma once

// Labelled views for training, codebooks and templates. perception requests them through this
// interface, sim renders them, and eval connects the two.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/base/ids.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

// Ground truth of one instance in a view.
struct LabelledInstance {
  ObjectId object{0};  // index into the source's ObjectSet
  Pose X_CO = Pose::Identity();
  double visible_fraction = 1;
};

// A camera image with the pose of each instance in it.
struct LabelledView {
  RgbdFrame frame;      // with the sensor's noise
  Image<uint16_t> ids;  // 0 = background, k + 1 = instances[k]
  std::vector<LabelledInstance> instances;
  std::optional<KnownBackground> background;  // given for clutter scenes
};

// What is around the bin of a clutter scene.
enum class Surroundings {
  kNone,        // nothing: only the bin is seen
  kRoomAndBin,  // a room with tables, walls and other things; the objects are in a bin
  kRoomNoBin,   // a room; the objects are on a table or on the floor
  kEmptyRoom,   // a room without any object of the source
};
inline bool IsRoom(Surroundings surroundings) { return surroundings != Surroundings::kNone; }

// Request for a clutter scene.
struct ClutterSceneRequest {
  uint64_t seed = 0;
  int views = 1;                 // number of viewpoints
  ObjectId object = kAnyObject;  // index of an object that must be in the scene; -1 = any
  bool typical = false;  // always use the source's usual bin and distances for objects of this size
  // Rooms are seen from more directions and distances, by more kinds of sensors. Their background
  // is given in the views, too.
  Surroundings surroundings = Surroundings::kNone;
};

// Source of labelled views.
class LabelledViewSource {
 public:
  virtual ~LabelledViewSource() = default;

  virtual const ObjectSet& objects() const = 0;

  // Returns a view of a single instance on an empty background for each of X_CO, seen by `camera`.
  // Sensor noise is drawn from `seed`. View i uses stream i, so the result does not depend on
  // batching.
  virtual std::vector<LabelledView> Isolated(ObjectId object, const std::vector<Pose>& X_CO,
                                             const CameraIntrinsics& camera, uint64_t seed) = 0;

  // Returns, as text, all settings besides the arguments that these views depend on. Data computed
  // from the views is only valid for the same text.
  virtual std::string IsolatedSettings() const = 0;

  // Returns views of a random settled clutter scene with these objects in a bin, from random
  // viewpoints. The same request gives the same scene. Some scenes have one kind of object, others
  // are mixed.
  virtual std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) = 0;

  // Same as IsolatedSettings(), for ClutterScene().
  virtual std::string ClutterSceneSettings() const = 0;
};

}  // namespace pickbed::scenes
