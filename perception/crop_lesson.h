#pragma once

// What a method for whole-object crops is made from: the parts, their templates, and further views
// to learn from.

#include <functional>
#include <vector>

#include "perception/crop_views.h"

namespace pickbed {

struct CropLesson {
  ObjectSet objects;
  std::vector<ObjectCrops> templates;  // of each object, as an ideal sensor sees them
  std::vector<ObjectCrops> training;   // of each object: further views, and noisy and relit ones
};

// Of every part: the templates; as training the views of train_level by `clean`, then templates and
// those again by `varied`, which may have a real sensor's noise and other lamps. Both sources are
// over the same objects. `on_share` (may be empty) is told how much is done; false = stop, upon
// which what comes back is unfinished.
CropLesson MakeCropLesson(LabelledViewSource& clean, LabelledViewSource& varied,
                          const CropViewOptions& options, uint64_t seed,
                          const std::function<bool(double share)>& on_share = {});

}  // namespace pickbed
