#pragma once

// Codebook of completed volumes: descriptors of views of an object, completed by the method that
// completes the query, with the pose of the object. Half of the views are partly hidden.
//
// Artefacts of the completion are then the same in query and codebook. Compared with true shapes,
// they would cost more than the completion gains.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "perception/completion/shape_completer.h"
#include "perception/segment_poses/volume_descriptor.h"
#include "scenes/base/ids.h"
#include "scenes/labelled_view.h"

namespace pickbed::perception {

struct VolumeBookOptions {
  int views = 600;
  double occluded_share = 0.5;  // of the views
  double min_hidden = 0.2;      // share of the visible pixels that an occluder hides
  double max_hidden = 0.6;
  double distance_m = 0.85;      // of the object, from the camera
  double distance_spread = 0.1;  // distances are distance_m * (1 -+ spread)
  double focal_px = 680;
  uint64_t seed = 0;
  void Visit(SettingsVisitor& v);
};

struct VolumeBook {
  double side_m = 0;          // of the descriptors' grid
  std::vector<float> values;  // entries x kDescriptorValues
  std::vector<Pose> X_FO;     // by entry
  size_t size() const { return X_FO.size(); }
};

// Renders and completes views of the object. Views that show too little of it are left out.
// `on_share` receives the progress, 0..1; it may be empty.
VolumeBook MakeVolumeBook(LabelledViewSource& views, ObjectId object, ShapeCompleter& completer,
                          const VolumeBookOptions& options,
                          const std::function<void(double share)>& on_share = {});

// Number of angles about its z axis in which a query is compared.
inline constexpr int kDescriptorTurns = 16;

// Returns the poses X_FO of the object in the frame F of a query, of the `count` nearest entries,
// nearest first. Each entry counts in the best of kDescriptorTurns angles. X_CF is VolumeFrame() of
// the query.
std::vector<Pose> NearestVolumes(const VolumeBook& book, const CompletedVolume& query,
                                 const Pose& X_CF, int count);

// Returns the content of the cache file (scenes/base/cache_file.h). `key` is a hash of everything
// that the entries depend on. The values are rounded to 8 bits.
std::string VolumeBookToBytes(const VolumeBook& book, uint64_t key);
// Returns the book of a content; nullopt if it was made for another key. Throws InputError if the
// content is cut short, its lists have sizes that do not fit together, or a pose is none.
std::optional<VolumeBook> VolumeBookFromBytes(std::string_view content, uint64_t key);

}  // namespace pickbed::perception
