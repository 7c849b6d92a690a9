#pragma once

// Benchmark of shape completion: all methods on the same views of test shapes.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "eval/completion/draw.h"
#include "eval/completion/measures.h"
#include "eval/layer.h"
#include "eval/stats/statistics.h"
#include "perception/completion/shape_completer.h"

namespace pickbed::eval {

struct CompletionBenchmarkOptions {
  std::vector<std::string> methods;   // rows of CompleterTable(), or kTrueShapes
  std::vector<std::string> sets;      // of TestSetNames()
  std::filesystem::path data_folder;  // with folders ycb and industrial of meshes
  // Model files or names in assets/models. A method uses the first of its kind.
  std::vector<std::string> models{"completion"};
  std::string sensor = "structured_light";  // profile of the test views
  double min_diameter_px = 60;              // of the shapes in the images
  // Probability above which a cell is full; 0 = perception::LevelForIou() of each completion.
  double level = 0;
  int shapes = 2;  // of each shape family
  int views = 2;   // of each shape, clean, and as many occluded
  int cells = 64;  // along each axis of the cube
  uint64_t seed = 1;
};

// Result of one method on one view.
struct CompletionRow {
  std::string method, set, shape;
  bool is_occluded = false;
  int view = 0;
  CompletionMeasures measures;
  double seconds = 0;
};

struct CompletionBenchmark {
  std::vector<std::string> methods, sets;
  std::vector<std::string> skipped_sets;  // sets without data
  std::vector<CompletionRow> rows;
  std::map<std::string, std::vector<CompletionTile>> gallery;  // first method, by set
};

// Returns the first model of this kind (perception::CompletionKinds()), or an empty name. Throws
// InputError for a file that is missing or damaged.
std::string ModelOfKind(const std::vector<std::string>& models, const std::string& kind);

// Returns the methods that need no model, or for which there is one, and kTrueShapes, which shows
// what the size of the cells costs.
std::vector<std::string> MethodsWith(const std::vector<std::string>& models);

// Runs the benchmark. `on_progress` gets the number of shapes done and of all; false stops it, and
// the result has the shapes so far, in turn from each set.
// Throws InputError for unknown and repeated names, without any test shape, and for a model or a
// data folder that cannot be read.
CompletionBenchmark RunCompletionBenchmark(
    const CompletionBenchmarkOptions& options,
    const std::function<bool(int done, int total)>& on_progress);

// Mean of a measure over shapes, with its 95 % interval: each shape counts once, with the mean of
// its views. The interval is Student's t, within the range of the measure (0 to 1) or of the
// difference (-1 to 1). It is unknown with less than kMinBinsOfInterval shapes.
struct ShapeMean {
  double mean = 0;
  Interval ci95;
  int shapes = 0;
};
using MeasureOf = double (*)(const CompletionMeasures& measures);
ShapeMean MeanOverShapes(const CompletionBenchmark& benchmark, const std::string& method,
                         const std::string& set, bool is_occluded, MeasureOf measure);

// Same for the difference between two methods on the same shapes.
ShapeMean DifferenceOverShapes(const CompletionBenchmark& benchmark, const std::string& method,
                               const std::string& other, const std::string& set, bool is_occluded,
                               MeasureOf measure);

}  // namespace pickbed::eval
