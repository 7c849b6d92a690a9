#pragma once

// Views with labels for training, code books and templates. perception asks for them through this
// interface; sim renders them; eval joins the two.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/bin.h"
#include "scenes/object_model.h"
#include "scenes/rgbd_frame.h"

namespace pickbed {

struct LabelledInstance {
  int object = 0;  // index into the source's ObjectSet
  Pose X_CO = Pose::Identity();
  double visible_fraction = 1;
};

struct LabelledView {
  RgbdFrame frame;      // with the sensor's noise
  Image<uint16_t> ids;  // 0 = background, k + 1 = instances[k]
  std::vector<LabelledInstance> instances;
  std::optional<KnownBackground> background;  // set for piles
};

struct PileRequest {
  uint64_t seed = 0;
  int views = 1;         // viewpoints
  int object = -1;       // that the pile must hold; -1 = any
  bool typical = false;  // only of the scale that the source takes as usual for such parts
};

class LabelledViewSource {
 public:
  virtual ~LabelledViewSource() = default;

  virtual const ObjectSet& objects() const = 0;

  // One object alone before an empty background at each of X_CO, seen by `camera`, with sensor
  // noise drawn from `seed` (view i uses stream i, so the result does not depend on batching).
  virtual std::vector<LabelledView> Isolated(int object, const std::vector<Pose>& X_CO,
                                             const CameraIntrinsics& camera, uint64_t seed) = 0;

  // All that these views depend on besides the arguments, as text: what is made from them is theirs
  // alone.
  virtual std::string IsolatedSettings() const = 0;

  // A random settled pile of these objects in a bin, seen from random viewpoints. The same request
  // gives the same pile. Piles of one kind and mixed ones both occur.
  virtual std::vector<LabelledView> Pile(const PileRequest& request) = 0;

  // As IsolatedSettings(), of piles.
  virtual std::string PileSettings() const = 0;
};

}  // namespace pickbed
