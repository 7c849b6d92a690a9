#pragma once

// Benchmark of the crop methods: every method on the same test views of every object under every
// condition, with and without ICP. ICP from random starts is the baseline.

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "eval/stats/statistics.h"
#include "perception/crop_methods/crop_conditions.h"
#include "perception/crop_methods/crop_method.h"
#include "scenes/base/ids.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {

struct CropBenchmarkOptions {
  uint64_t seed = 0;
  int tests = 60;      // views per object and condition
  int k = 1;           // number of nearest templates from which ICP starts; the best result is kept
  int icp_starts = 8;  // kIcpOnly: number of random orientations; the best result is kept
  std::string sensor = "structured_light";  // sensor of the noisy condition and of training
  CropViewOptions views;
  CropMethodOptions methods;
  void Visit(SettingsVisitor& v);
};

// Processing of a method's answers: none, ICP from the answers, or ICP without a method.
enum class CropStage { kNearest, kNearestIcp, kIcpOnly };
// Returns the name of a stage in tables and files.
const char* CropStageName(CropStage stage);

// Upper bound and baseline. They are no methods because they know the object.
inline constexpr const char* kOracleMethod = "oracle";         // template nearest to ground truth
inline constexpr const char* kRandomStarts = "random_starts";  // with kIcpOnly

// Result of one method and stage on one test view.
struct CropRecord {
  std::string method;
  CropStage stage = CropStage::kNearest;
  ObjectId object{0};
  int condition = 0;  // row of CropConditionTable()
  int test = 0;
  ObjectId found_object{-1};  // -1 = no answer
  double occluded = 0;        // occluded fraction, 0..1
  // Rotation error, minimum over the symmetries. Infinite if the object is wrong.
  double angle_rad = std::numeric_limits<double>::infinity();
  double seconds = 0;  // mean time of this stage per crop
};

struct CropBenchmarkJob {
  ObjectSet objects;
  std::vector<std::string> methods;     // rows of CropMethodTable()
  std::vector<std::string> conditions;  // rows of CropConditionTable()
  CropBenchmarkOptions options;
  std::filesystem::path models;  // folder of the trained models
  int threads = 1;               // upper limit; the results are the same for any number
  // Receives the current step and the completed share 0..1. Returns false to stop. May be empty.
  std::function<bool(const std::string& what, double share)> on_progress;
};

struct CropBenchmark {
  std::vector<CropRecord> records;
  struct Training {
    std::string method;
    double seconds = 0;  // time to make the method: training, description of templates
  };
  std::vector<Training> training;
  bool finished = false;
};

// Runs the benchmark. If `on_progress` stops it, the result is partial and not `finished`. Throws
// InputError for unknown names, options out of range and a job without objects.
CropBenchmark RunCropBenchmark(const CropBenchmarkJob& job);

}  // namespace pickbed::eval
