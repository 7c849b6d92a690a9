#pragma once

// What is shape completion worth for grasping unknown objects? Planners pick the same sampled
// shapes in physics: each shape as the only one in the bin, and in bins of several. The unit of
// intervals of rates is a shape. The difference of the success of two planners is paired by bin.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "eval/benchmark/grasp_gallery.h"
#include "eval/compare/paired_comparison.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"
#include "eval/shapes/segment_shapes.h"
#include "eval/stats/statistics.h"
#include "eval/trial/trial_records.h"

namespace pickbed::eval {

inline constexpr char kCompletedGraspsFile[] = "completion_grasps.csv";
inline constexpr char kCompletedGraspsShapesFile[] = "completion_grasps_shapes.csv";

struct CompletedGraspsOptions {
  // Rows of the table: planners without poses, or kTrueShapes for the planner `completed` with the
  // true shapes. The first is the reference.
  std::vector<std::string> planners{"completed", "skirt", "cloud_antipodal", kTrueShapes};
  std::string completion = "network";       // of planner completed: a method or a model file
  std::string scenario = "clutter_unseen";  // name or file; its bins draw from a pool of shapes
  int single = 16;                          // drops of a single shape
  int bins = 8;
  uint64_t seed = 9300;
  bool pictures = false;  // fills CompletedGrasps::gallery
};

// Grasps of one shape by one planner.
struct ShapeGrasps {
  Cluster grasps;  // (succeeded, executed)
  Cluster picked;  // (picked, dropped)
};

struct CompletedGrasps {
  std::vector<std::string> planners;
  // By condition ("single", "bins"), planner and shape.
  std::map<std::string, std::map<std::string, std::map<std::string, ShapeGrasps>>> shapes;
  // Grasps (succeeded, executed) of each bin by condition and planner. All planners of a condition
  // have the same bins in the same order.
  std::map<std::string, std::map<std::string, std::vector<Cluster>>> bins;
  // Pictures of the first picks by condition and planner, also of an unfinished bin.
  std::map<std::string, std::map<std::string, std::vector<GraspTile>>> gallery;
};
inline constexpr const char* kGraspConditions[] = {"single", "bins"};

// Adds the grasps of a trial to the shapes and returns their sum. `names`: name of each object. A
// grasp belongs to the shape that came or was nearest.
Cluster AddTrial(const TrialResult& trial, const std::vector<std::string>& names,
                 std::map<std::string, ShapeGrasps>& shapes);

// Throws InputError for an unknown or repeated planner, a planner on poses, a scenario without a
// pool, and without any bin.
void CheckCompletedGrasps(const CompletedGraspsOptions& options);

// `on_progress` gets the number of trials done and of all; false stops it, and the result has the
// bins that all planners have picked. Throws as CheckCompletedGrasps().
CompletedGrasps RunCompletedGrasps(const CompletedGraspsOptions& options,
                                   const std::function<bool(int done, int total)>& on_progress);

// A rate of a planner over the shapes of a condition, and its difference to the reference.
struct GraspRate {
  ReportRate rate;
  Interval difference;  // 95 %, paired by shape
};
// Returns the rate of `value`: ShapeGrasps::grasps or ShapeGrasps::picked.
GraspRate GraspRateOf(const CompletedGrasps& grasps, const std::string& condition,
                      const std::string& planner, Cluster ShapeGrasps::*value);

// Returns the difference of the share of grasps that succeed to the first planner, paired by bin.
PairedStatistic SuccessDifference(const CompletedGrasps& grasps, const std::string& condition,
                                  const std::string& planner);

std::string CompletedGraspsText(const CompletedGrasps& grasps);
std::string CompletedGraspsCsv(const CompletedGrasps& grasps);
ResultColumns CompletedGraspsColumns();
std::string CompletedGraspsShapesCsv(const CompletedGrasps& grasps);
ResultColumns CompletedGraspsShapesColumns();
// Appends the table and the gallery to a page, and writes the pictures of the gallery to `folder`.
// Throws InputError if they cannot be written.
void AddCompletedGrasps(const std::filesystem::path& folder, const CompletedGrasps& grasps,
                        HtmlPage& page);

}  // namespace pickbed::eval
