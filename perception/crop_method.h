#pragma once

// The plug-in boundary of whole-object crops: crops in, for each the parts and orientations that it
// most likely shows. A method never sees the truth. Adding one is one file and one row in
// crop_method.cpp.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "perception/crop_lesson.h"
#include "perception/networks/wohlhart.h"

namespace pickbed {

struct CropAnswer {
  int object = 0;  // index into the ObjectSet
  Eigen::Matrix3d R_CO = Eigen::Matrix3d::Identity();
  double distance = 0;  // by the method's own measure; less is better
  int view = -1;        // row of the part's templates that it is; -1 = none
  friend bool operator==(const CropAnswer&, const CropAnswer&) = default;
};

class CropMethod {
 public:
  virtual ~CropMethod() = default;
  // By crop, at most k answers, best first. The same for any number of threads.
  virtual std::vector<std::vector<CropAnswer>> Answer(const CropSet& crops, int k,
                                                      int threads) const = 0;
};

struct CropMethodOptions {
  uint64_t seed = 0;
  // The pushers are the hardest of a batch: of crops that are rendered once, steps of many anchors
  // teach more in the same time than more steps of few.
  WohlhartOptions wohlhart{.anchors = 128, .iterations = 200};
  void Visit(SettingsVisitor& v);
};

struct CropMethodSetup {
  std::shared_ptr<const CropLesson> lesson;  // kept by methods that look up its templates
  CropMethodOptions options;
  // Where a method that learns keeps what it has learned, and goes on from; empty = nowhere.
  std::filesystem::path folder;
  int threads = 1;
  // Share of the work that is done; false = stop, upon which the method is null. May be empty.
  std::function<bool(double share)> on_progress;
};

struct CropMethodRow {
  const char* name;
  const char* help;
  std::unique_ptr<CropMethod> (*make)(const CropMethodSetup& setup);
};

std::span<const CropMethodRow> CropMethodTable();

}  // namespace pickbed
