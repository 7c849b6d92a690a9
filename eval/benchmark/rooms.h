#pragma once

// Are scores right where the background is not known? Simulated rooms with objects in bins, with
// objects on tables among other things, and without any object. The same images are estimated
// without and with the given bin. Every second image is also estimated without looking for planes,
// as if none had been found.

#include <functional>
#include <string>
#include <vector>

#include "eval/estimate/estimator_comparison.h"
#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "eval/stats/forecast_quality.h"
#include "eval/trial/pose_matching.h"
#include "scenes/labelled_view.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

inline constexpr char kRoomsFile[] = "rooms.csv";

struct RoomsOptions {
  int bins = 20, tables = 10, empty = 30;  // number of images of each kind
  uint64_t seed = 9300;                    // other rooms than in a training
  int threads = 1;
};

// What is known about the background of an image.
inline constexpr char kGivenBackground[] = "given";    // the bin is given
inline constexpr char kFittedBackground[] = "fitted";  // planes were found in the image
inline constexpr char kUnknownBackground[] = "unknown";

// One estimate of an image.
struct RoomEstimate {
  std::string rooms;       // "bin", "table" or "empty"
  std::string background;  // one of the above
  bool fits_background = true;
  ComparedImage image = {};  // with all poses with a score of at least kMinRoomScore
};
inline constexpr double kMinRoomScore = 0.05;

// Results in the images of one kind of room, or of one kind of background.
struct RoomsRow {
  std::string rooms;       // "bin", "table", "empty" or "all"
  std::string background;  // one of the above, or "all" that look for planes
  int images = 0;
  int instances = 0, recalled = 0;  // at least 10 % visible; at the minimum score
  int poses = 0, right = 0;         // reported at the minimum score
  // ECE over all poses with a score of at least kMinRoomScore; interval over images.
  ClusterValue calibration_error = {};
  double highest_false = 0;  // highest score of a wrong pose; 0 = none
  double seconds = 0;        // mean per image
};

// Called while rooms are estimated.
struct RoomsCallbacks {
  // Gets the number of images done and of all. If it returns false, the estimation stops.
  std::function<bool(int done, int total)> on_progress;
  std::function<void(const LabelledView& view, const RoomEstimate& estimate)> on_estimate = {};
};

// Estimates the images of `views` by the estimator of `spec`; spec.min_score is not used. Returns
// nothing if it was stopped. Throws InputError as MakeEstimator().
std::vector<RoomEstimate> EstimateRooms(LabelledViewSource& views, const EstimatorSpec& spec,
                                        const RoomsOptions& options,
                                        const RoomsCallbacks& callbacks);

// Drops poses with a lower score from the result of an image.
void KeepReported(double min_score, AttemptScore& score);

// Returns the rows. Poses with a lower score than `min_score` are not reported.
std::vector<RoomsRow> RoomsRowsOf(const std::vector<RoomEstimate>& estimates, double min_score);

std::string RoomsText(const std::vector<RoomsRow>& rows);
std::string RoomsCsv(const std::vector<RoomsRow>& rows);
ResultColumns RoomsColumns();

}  // namespace pickbed::eval
