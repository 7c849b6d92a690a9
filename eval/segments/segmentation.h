#pragma once

// Segments images into unknown objects with several methods, and scores them against labels: in
// simulated bins, and in labelled clouds of real sensors.

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/segments/segment_scores.h"
#include "perception/segments/object_segments.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

inline constexpr char kSegmentsFile[] = "segments.csv";
inline constexpr char kSegmentScoresFile[] = "segment_scores.csv";

// Minimum visible fraction of an instance that counts for recall. Labelled clouds do not say how
// much of an instance is hidden, so there each instance counts.
inline constexpr double kHalfVisible = 0.5;

struct SegmentationOptions {
  std::vector<std::string> methods;  // rows of SegmenterTable(); empty = all
  std::filesystem::path pictures;    // folder of overlay pictures; empty = none
  int pictured_images = 5;
  // Labels of a cloud up to this one are background, such as a table.
  int background_label = 1;
};

// Result of one method on one image.
struct SegmentedImage {
  std::string name;  // "trial_0000", or the name of the file without its extension
  SegmentScores scores;
  double seconds = 0;
};

// Results of one method on all images.
struct SegmentationRow {
  std::string method;
  std::vector<SegmentedImage> images;
};

// Called after each image. Returns false to stop.
using SegmentationProgress = std::function<bool(int done, int total)>;

// Segments the first image of each bin of a scenario. Throws InputError, see SimulatedCell.
std::vector<SegmentationRow> SegmentBins(const ScenarioSpec& spec, const ObjectSet& objects,
                                         const SegmentationOptions& options,
                                         const SegmentationProgress& on_image);

// Segments the *.pcd files of a folder, in the order of their names; see ReadLabelledCloud().
// Throws InputError if the folder has none, or for a file that cannot be read.
std::vector<SegmentationRow> SegmentClouds(const std::filesystem::path& folder,
                                           const SegmentationOptions& options,
                                           const SegmentationProgress& on_image);

// Text table for the console, one column per method.
std::string SegmentationTable(std::span<const SegmentationRow> rows);
// The same numbers as JSON.
std::string SegmentationJson(std::span<const SegmentationRow> rows);
// One line per method and image. Times are not in it.
std::string SegmentScoresCsv(std::span<const SegmentationRow> rows);
ResultColumns SegmentScoresColumns();
// One line per method, image and instance.
std::string SegmentsCsv(std::span<const SegmentationRow> rows);
ResultColumns SegmentsColumns();

// Returns the picture with the segments as transparent colors, and the borders between labels as
// lines. `labels` has the size of the picture; 0 = no segment.
Image<Rgb8> SegmentOverlay(const Image<Rgb8>& picture, const Image<uint16_t>& labels);

}  // namespace pickbed::eval
