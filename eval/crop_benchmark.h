#pragma once

// The crop table: every crop method on the same test views of every part under every condition,
// alone and with ICP, beside ICP from random starts.

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "eval/statistics.h"
#include "perception/crop_conditions.h"
#include "perception/crop_method.h"
#include "sim/sensor_profile.h"

namespace pickbed {

struct CropBenchmarkOptions {
  uint64_t seed = 0;
  int tests = 60;      // views a part and condition
  int k = 1;           // nearest answers that ICP starts from, best result kept
  int icp_starts = 8;  // of ICP alone: random orientations, best result kept
  std::string sensor = "structured_light";  // of the noisy condition and of training
  CropViewOptions views;
  CropMethodOptions methods;
  void Visit(SettingsVisitor& v);
};

// What is done with a method's answers.
enum class CropStage { kNearest, kNearestIcp, kIcpAlone };
const char* CropStageName(CropStage stage);

// The ceiling and the comparison that are no methods, since they know the part.
inline constexpr const char* kOracleMethod = "oracle";         // nearest template to the truth
inline constexpr const char* kRandomStarts = "random_starts";  // with kIcpAlone

struct CropRecord {
  std::string method;
  CropStage stage = CropStage::kNearest;
  int object = 0;
  int condition = 0;  // row of CropConditionTable()
  int test = 0;
  int found_object = -1;  // -1 = no answer
  double occluded = 0;    // share
  // Of the orientation, least over symmetries; infinite where the part is wrong.
  double angle_rad = std::numeric_limits<double>::infinity();
  double seconds = 0;  // of this stage, a crop
};

struct CropBenchmarkJob {
  ObjectSet objects;
  std::vector<std::string> methods;     // rows of CropMethodTable()
  std::vector<std::string> conditions;  // rows of CropConditionTable()
  CropBenchmarkOptions options;
  std::filesystem::path models;  // where learned methods keep what they learn
  int threads = 1;               // at most; results are the same for any number
  // What is done and how much of all; false = stop. May be empty.
  std::function<bool(const std::string& what, double share)> on_progress;
};

struct CropBenchmark {
  std::vector<CropRecord> records;
  struct Training {
    std::string method;
    double seconds = 0;  // to make the method: training, description of templates
  };
  std::vector<Training> training;
  bool finished = false;
};

// Throws InputError for unknown names and for options out of range.
CropBenchmark RunCropBenchmark(const CropBenchmarkJob& job);

}  // namespace pickbed
