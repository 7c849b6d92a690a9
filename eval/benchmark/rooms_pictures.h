#pragma once

// Pictures of wrong poses in simulated rooms.

#include <filesystem>

#include "eval/benchmark/rooms.h"
#include "eval/layer.h"
#include "scenes/labelled_view.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Writes the image with all poses of at least `min_score` to NUMBER_ROOMS_BACKGROUND.png in
// `folder`, for example 007_bin_fitted.png, if one of them is wrong. If planes were not searched,
// the name ends with _planes_off. `objects` are the objects of the poses. Returns whether a picture
// was written. Throws InputError if it cannot be written.
bool WriteRoomWithWrongPoses(const std::filesystem::path& folder, const ObjectSet& objects,
                             const LabelledView& view, const RoomEstimate& estimate,
                             double min_score);

// Removes the pictures that earlier calls have written to the folder, and no other file.
void RemoveRoomPictures(const std::filesystem::path& folder);

}  // namespace pickbed::eval
