#pragma once

// Does shape completion improve the recognition of known objects? The estimator `descriptor`
// estimates the same images without completion and with each method of completion
// (EstimatorSpec::completion). Differences are paired by bin.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/benchmark/bins.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"

namespace pickbed::eval {

inline constexpr char kRecognitionFile[] = "recognition.csv";
inline constexpr char kRecognitionBinsFile[] = "recognition_bins.csv";

struct RecognitionOptions {
  std::vector<std::string> scenarios;                                // names or files
  int bins = 8;                                                      // of each scenario
  std::string mode = "accurate";                                     // of estimator descriptor
  std::vector<std::string> completions{"none", "skirt", "network"};  // the first is the reference
  std::string model = "completion";                                  // of method network
  uint64_t seed = 9100;
  // Folder that gets the pictures of Recognition::gallery; empty = no pictures. Pictures of an
  // earlier benchmark in it are removed.
  std::filesystem::path pictures;
};

// Result of one completion in one bin.
struct RecognitionBin {
  std::string scenario, completion;
  int bin = 0;
  std::vector<Cluster> bands;  // (recalled, instances) by visible fraction, EmptyRecallBands()
  Cluster poses;               // (right, reported)
  double seconds = 0;          // of the estimate
};

// Recalled instances of one image with two completions. Only instances at least 10 % visible count.
struct RecalledChange {
  int instances = 0;
  int recalled_before = 0, recalled_after = 0;
  int gained = 0, lost = 0;
};
// Compares two results for the same image.
RecalledChange ChangeInImage(const std::vector<InstanceRecord>& before,
                             const std::vector<InstanceRecord>& after);

// Pictures of one image, with the poses of the reference and of the last completion.
struct RecognitionPictures {
  std::string scenario;
  int bin = 0;
  RecalledChange change;
  std::filesystem::path without, with;  // overlays, relative to RecognitionOptions::pictures
};

struct Recognition {
  std::vector<std::string> completions;  // the first is the reference
  std::vector<RecognitionBin> bins;      // of a bin in the order of the completions
  // The first image, and some images in which the last completion gained or lost instances.
  std::vector<RecognitionPictures> gallery;
};

// Throws InputError for unknown names and repeated completions.
void CheckRecognition(const RecognitionOptions& options);

// `on_progress` gets the number of bins done and of all; false stops it, and the result has the
// bins so far. Throws as CheckRecognition().
Recognition RunRecognition(const RecognitionOptions& options,
                           const std::function<bool(int done, int total)>& on_progress);

// Recall between 30 and 70 % visible.
inline constexpr double kOccludedFrom = 0.3, kOccludedTo = 0.7;
// A rate with and without completion.
struct RecognitionChange {
  ReportRate reference, rate;
  Interval difference;  // of the rates, 95 %, paired by bin
  double p = 1;         // of PairedRateTest(), over bins
};
// Returns the recall of instances whose visible fraction is in a range of whole bands. An empty
// scenario means all.
RecognitionChange RecallChange(const Recognition& recognition, const std::string& completion,
                               double from, double to, const std::string& scenario = "");
// Returns the share of reported poses that are right.
RecognitionChange PrecisionChange(const Recognition& recognition, const std::string& completion);

std::string RecognitionText(const Recognition& recognition);
std::string RecognitionCsv(const Recognition& recognition);
ResultColumns RecognitionColumns();
std::string RecognitionBinsCsv(const Recognition& recognition);
ResultColumns RecognitionBinsColumns();
// Appends the tables and the gallery to a page. `pictures` is RecognitionOptions::pictures relative
// to the folder of the page.
void AddRecognition(const Recognition& recognition, const std::filesystem::path& pictures,
                    HtmlPage& page);

}  // namespace pickbed::eval
