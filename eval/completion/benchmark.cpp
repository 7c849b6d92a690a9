#include "eval/completion/benchmark.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "eval/completion/sensors.h"
#include "eval/completion/test_shapes.h"
#include "eval/shapes/completion_choice.h"
#include "perception/completion/completion_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

constexpr size_t kGalleryTiles = 12;  // of each set

// Mean of the views of each shape, in the order of the rows.
std::vector<double> ShapeValues(const CompletionBenchmark& benchmark, const std::string& method,
                                const std::string& set, bool is_occluded, MeasureOf measure) {
  std::vector<std::string> shapes;
  std::vector<double> sums, counts;
  for (const CompletionRow& row : benchmark.rows) {
    if (row.method != method || row.set != set || row.is_occluded != is_occluded) continue;
    if (shapes.empty() || shapes.back() != row.shape) {
      shapes.push_back(row.shape);
      sums.push_back(0);
      counts.push_back(0);
    }
    sums.back() += measure(row.measures);
    counts.back() += 1;
  }
  for (size_t i = 0; i < sums.size(); ++i) sums[i] /= counts[i];
  return sums;
}

// `range`: of the values; the interval does not leave it.
ShapeMean MeanOf(const std::vector<double>& values, const Interval& range) {
  ShapeMean result;
  result.shapes = static_cast<int>(values.size());
  result.ci95 = Interval::Unknown();
  if (values.empty()) return result;
  const double count = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / count;
  if (result.shapes < kMinBinsOfInterval) return result;
  double variance = 0;
  for (const double value : values) {
    variance += (value - result.mean) * (value - result.mean) / (count - 1);
  }
  const double half = TwoSidedT(0.95, count - 1) * std::sqrt(variance / count);
  result.ci95 = {std::max(result.mean - half, range.low), std::min(result.mean + half, range.high)};
  return result;
}

// A name given twice would count its shapes twice.
void RequireDifferent(std::vector<std::string> names, const char* what) {
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  CheckInput(twice == names.end(), fmt::format("{} '{}' is given twice; give it once", what,
                                               twice == names.end() ? "" : *twice));
}

RandomView DrawTestView(const TestShape& shape, const std::vector<DepthSensor>& sensors,
                        const RandomViewOptions& options, Rng& rng) {
  try {
    return DrawView(*shape.solid, sensors, options, rng);
  } catch (const InputError& error) {
    throw InputError(fmt::format("shape {} of set {}: {}", shape.name, shape.set, error.what()));
  }
}

// Returns the first shape of each set, then the second one of each, and so on. So an interrupted
// benchmark has shapes of all sets.
std::vector<TestShape> InTurn(std::vector<std::vector<TestShape>> sets) {
  std::vector<TestShape> shapes;
  size_t rounds = 0;
  for (const auto& set : sets) rounds = std::max(rounds, set.size());
  for (size_t i = 0; i < rounds; ++i) {
    for (auto& set : sets) {
      if (i < set.size()) shapes.push_back(std::move(set[i]));
    }
  }
  return shapes;
}

// An unknown method has no row; MakeCompleter() refuses it.
std::string ModelFor(const std::string& method, const std::vector<std::string>& models) {
  for (const CompleterRow& row : CompleterTable()) {
    if (row.name != method || row.kind == nullptr) continue;
    const std::string model = ModelOfKind(models, row.kind);
    CheckInput(!model.empty(), fmt::format("method {} needs a model of kind {}, and there is none "
                                           "in {}; train one with `pickbed train completion --set "
                                           "network.kind={}`",
                                           method, row.kind, fmt::join(models, ", "), row.kind));
    return model;
  }
  return {};
}

}  // namespace

std::string ModelOfKind(const std::vector<std::string>& models, const std::string& kind) {
  for (const std::string& model : models) {
    const auto file = TrainedFile(model);
    if (perception::LoadCompletionModel(file).info.network.kind == kind) return model;
  }
  return {};
}

std::vector<std::string> MethodsWith(const std::vector<std::string>& models) {
  std::vector<std::string> methods;
  for (const CompleterRow& row : CompleterTable()) {
    if (row.kind == nullptr || !ModelOfKind(models, row.kind).empty()) methods.push_back(row.name);
  }
  methods.push_back(kTrueShapes);
  return methods;
}

CompletionBenchmark RunCompletionBenchmark(
    const CompletionBenchmarkOptions& options,
    const std::function<bool(int done, int total)>& on_progress) {
  RequireDifferent(options.methods, "method");
  RequireDifferent(options.sets, "set");
  CheckInput(options.data_folder.empty() || std::filesystem::is_directory(options.data_folder),
             fmt::format("{}: no such folder; give a folder with the folders ycb and industrial",
                         options.data_folder.string()));
  CompletionBenchmark benchmark;
  benchmark.methods = options.methods;
  std::vector<std::unique_ptr<ShapeCompleter>> completers;  // null: the truth
  for (const std::string& method : options.methods) {
    if (method == kTrueShapes) {
      completers.push_back(nullptr);
      continue;
    }
    CompletionOptions own;
    own.method = method;
    own.model = ModelFor(method, options.models);
    own.cells = options.cells;
    completers.push_back(MakeCompleter(own));
  }
  const auto first_completer =
      std::ranges::find_if(completers, [](const auto& completer) { return completer != nullptr; });
  CheckInput(first_completer != completers.end(),
             fmt::format("method '{}' needs another method, whose cells it fills", kTrueShapes));
  const std::vector<DepthSensor> sensors = DepthSensorsNamed({options.sensor});
  std::vector<std::vector<TestShape>> by_set;
  for (const std::string& set : options.sets) {
    std::vector<TestShape> some = TestShapesOf(set, options.shapes, options.data_folder);
    (some.empty() ? benchmark.skipped_sets : benchmark.sets).push_back(set);
    by_set.push_back(std::move(some));
  }
  const std::vector<TestShape> shapes = InTurn(std::move(by_set));
  CheckInput(!shapes.empty(), fmt::format("no test shapes in {}; give --data with their meshes",
                                          fmt::join(options.sets, ", ")));
  const int total = static_cast<int>(shapes.size());
  for (int i = 0; i < total; ++i) {
    if (!on_progress(i, total)) return benchmark;
    const TestShape& shape = shapes[i];
    Rng rng = Rng::Derive(options.seed, HashBytes(shape.name.data(), shape.name.size()),
                          "completion benchmark");
    const double diameter_m = shape.solid->box_O().diagonal().norm();
    std::vector<CompletionTile>& tiles = benchmark.gallery[shape.set];
    // Shows a clean and an occluded view in turn.
    const int shown = static_cast<int>(tiles.size() % 2) * options.views;
    for (int view = 0; view < 2 * options.views; ++view) {
      RandomViewOptions views;
      const bool is_occluded = view >= options.views;
      views.occluded_share = is_occluded ? 1 : 0;
      views.min_diameter_px = options.min_diameter_px;
      const RandomView drawn = DrawTestView(shape, sensors, views, rng);
      std::vector<CompletedVolume> completed;
      std::vector<double> seconds;
      for (const auto& completer : completers) {
        const auto start = std::chrono::steady_clock::now();
        completed.push_back(completer ? completer->Complete(drawn.view) : CompletedVolume());
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        seconds.push_back(taken.count());
      }
      const CompletedVolume truth =
          TrueVolume(*shape.solid, drawn, completed[first_completer - completers.begin()]);
      const std::vector<Eigen::Vector3f> surface = TrueSurfacePoints(*shape.solid, drawn, truth);
      for (size_t m = 0; m < completers.size(); ++m) {
        if (!completers[m]) completed[m] = truth;
        const float level = options.level > 0 ? static_cast<float>(options.level)
                                              : perception::LevelForIou(completed[m]);
        benchmark.rows.push_back(
            {options.methods[m], shape.set, shape.name, is_occluded, view,
             MeasureCompletion(completed[m], truth, surface, drawn, diameter_m, level),
             seconds[m]});
      }
      if (tiles.size() < kGalleryTiles && view == shown)
        tiles.push_back({shape.name, drawn.view, completed.front(), truth});
    }
  }
  on_progress(total, total);
  return benchmark;
}

ShapeMean MeanOverShapes(const CompletionBenchmark& benchmark, const std::string& method,
                         const std::string& set, bool is_occluded, MeasureOf measure) {
  return MeanOf(ShapeValues(benchmark, method, set, is_occluded, measure), {0, 1});
}

ShapeMean DifferenceOverShapes(const CompletionBenchmark& benchmark, const std::string& method,
                               const std::string& other, const std::string& set, bool is_occluded,
                               MeasureOf measure) {
  std::vector<double> values = ShapeValues(benchmark, method, set, is_occluded, measure);
  const std::vector<double> subtracted = ShapeValues(benchmark, other, set, is_occluded, measure);
  for (size_t i = 0; i < values.size(); ++i) values[i] -= subtracted[i];
  return MeanOf(values, {-1, 1});
}

}  // namespace pickbed::eval
