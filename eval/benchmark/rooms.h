#pragma once

// Are scores right where the background is not known? Simulated rooms with objects in bins, with
// objects on tables among other things, and without any object. The same images are estimated
// without and with the given bin.

#include <functional>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "scenes/labelled_view.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

inline constexpr char kRoomsFile[] = "rooms.csv";

struct RoomsOptions {
  int bins = 20, tables = 10, empty = 30;  // number of images of each kind
  uint64_t seed = 9300;                    // other rooms than in a training
  int threads = 1;
};

// Results in the images of one kind of room, or of one kind of background.
struct RoomsRow {
  std::string rooms;       // "bin", "table", "empty" or "all"
  std::string background;  // "given", "fitted" (planes were found), "unknown" or "all"
  int images = 0;
  int instances = 0, recalled = 0;  // at least 10 % visible; at the minimum score
  int poses = 0, right = 0;         // reported at the minimum score
  double calibration_error = 0;     // ECE over all poses with a score of at least 0.05
  double highest_false = 0;         // highest score of a wrong pose; 0 = none
  double seconds = 0;               // mean per image
};

// Estimates the images of `views` by the estimator of `spec`. Minimum score is spec.min_score.
// `on_progress` gets the number of images done and of all; false stops it, and the result has the
// images so far. Throws InputError as MakeEstimator().
std::vector<RoomsRow> RunRooms(LabelledViewSource& views, const EstimatorSpec& spec,
                               const RoomsOptions& options,
                               const std::function<bool(int done, int total)>& on_progress);

std::string RoomsText(const std::vector<RoomsRow>& rows);
std::string RoomsCsv(const std::vector<RoomsRow>& rows);
ResultColumns RoomsColumns();

}  // namespace pickbed::eval
