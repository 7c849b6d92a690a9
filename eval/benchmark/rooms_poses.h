#pragma once

// Table of the poses of `pickbed benchmark rooms`, to study which poses are wrong.

#include <string>

#include "eval/benchmark/rooms.h"

namespace pickbed::eval {

inline constexpr char kRoomPosesFile[] = "room_poses.csv";

ResultColumns RoomPosesColumns();

// Returns one line for each pose of one estimate of `view`.
std::string RoomPosesLines(const ObjectSet& objects, const LabelledView& view,
                           const RoomEstimate& estimate);

}  // namespace pickbed::eval
