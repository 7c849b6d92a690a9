#pragma once

// Plug-in interface of methods for whole-object crops. A method returns the most likely objects and
// orientations for each crop and never gets ground truth. A new method is one file and one row in
// crop_method.cpp.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "perception/crops/crop_views.h"
#include "perception/networks/wohlhart.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// One object and orientation that a crop may show.
struct CropAnswer {
  ObjectId object{0};  // index into the ObjectSet
  Eigen::Matrix3d R_CO = Eigen::Matrix3d::Identity();
  double distance = 0;  // in the method's own measure; lower is better
  int view = -1;        // index of the matched template of the object; -1 = not reported
  friend bool operator==(const CropAnswer&, const CropAnswer&) = default;
};

// Interface of a method.
class CropMethod {
 public:
  virtual ~CropMethod() = default;
  // Returns at most k answers per crop, best first. Does not depend on the number of threads.
  virtual std::vector<std::vector<CropAnswer>> Answer(const CropSet& crops, int k,
                                                      int threads) const = 0;
};

struct CropMethodOptions {
  uint64_t seed = 0;
  // The pushers are the hardest ones of a batch. Because crops are rendered only once, few steps
  // with many anchors train better in the same time than many steps with few anchors.
  WohlhartOptions wohlhart{.anchors = 128, .iterations = 200};
  void Visit(SettingsVisitor& v);
};

// Inputs for making a method.
struct CropMethodSetup {
  std::shared_ptr<const CropTrainingSet>
      training_set;  // kept by methods that look up its templates
  CropMethodOptions options;
  // Checkpoint folder of methods that are trained; training resumes from it. Empty = none.
  std::filesystem::path folder;
  int threads = 1;
  // Receives the progress, 0..1. If it returns false, no method is made (null). May be empty.
  std::function<bool(double share)> on_progress;
};

// One row of the method table. `make` returns null if on_progress stopped it.
struct CropMethodRow {
  const char* name;
  const char* help;
  std::unique_ptr<CropMethod> (*make)(const CropMethodSetup& setup);
};

// Returns all methods.
std::span<const CropMethodRow> CropMethodTable();

}  // namespace pickbed::perception
