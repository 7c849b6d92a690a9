#pragma once

// What one reads off a finished run or sweep, made from its store alone.
//
//   OUT/summary.json                        of each point; of a run, of its one point
//   OUT/{trials,picks,parts,points}.csv     a line a trial, pick, part, point
//   OUT/timings.csv                         seconds by trial and stage, the only file with times
//   OUT/{curve.csv,pictures/occlusion.png}  of occlusion trials: by band of the visible fraction

#include <filesystem>
#include <string>
#include <vector>

#include "eval/summary.h"

namespace pickbed {

struct PointSummary {
  StoredPoint point;
  RunSummary summary;
};

// Reads OUT/results.sqlite point by point and writes the files beside it. Throws InputError for a
// store that cannot be read and a folder that cannot be written.
std::vector<PointSummary> WriteSweepFiles(const std::filesystem::path& out);

// File of a point's settings: number and name, without letters that file systems do not take.
std::string PointFileName(int point, const std::string& name);

// For people: the summary of a run; of a sweep a line a point.
std::string SweepTable(const std::vector<PointSummary>& points);
// summary.json
std::string SweepJson(const std::vector<PointSummary>& points);

}  // namespace pickbed
