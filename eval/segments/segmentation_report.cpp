// Text table, JSON and CSV of the results in eval/segments/segmentation.h.

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "eval/metrics/interval_json.h"
#include "eval/segments/segmentation.h"
#include "eval/stats/statistics.h"

namespace pickbed::eval {
namespace {

// Statistics of one method over all images.
struct Statistics {
  int images = 0;
  int labelled_images = 0;  // with an instance
  ReportRate recall_50, recall_75, precision_50, precision_75;
  // Means over labelled images.
  double weighted_overlap = 0, over = 0, under = 0, under_error = 0;
  double segments = 0;  // mean segments of a counted instance that is found at all
  double seconds = 0;   // mean
};

Statistics StatisticsOf(const SegmentationRow& row) {
  Statistics s;
  s.images = static_cast<int>(row.images.size());
  s.labelled_images = static_cast<int>(std::ranges::count_if(
      row.images, [](const SegmentedImage& image) { return !image.scores.instances.empty(); }));
  std::vector<Cluster> recall_50, recall_75, precision_50, precision_75;
  int pieces = 0, found = 0;
  for (const SegmentedImage& image : row.images) {
    Cluster of_50, of_75;
    for (const SegmentedInstance& instance : image.scores.instances) {
      if (!instance.is_counted) continue;
      ++of_50.samples;
      ++of_75.samples;
      of_50.hits += instance.iou > 0.5;
      of_75.hits += instance.iou >= 0.75;
      pieces += instance.segments;
      found += instance.segments > 0;
    }
    recall_50.push_back(of_50);
    recall_75.push_back(of_75);
    precision_50.push_back({image.scores.matched_50, image.scores.segments});
    precision_75.push_back({image.scores.matched_75, image.scores.segments});
    s.seconds += image.seconds / s.images;
    if (image.scores.instances.empty()) continue;
    s.weighted_overlap += image.scores.weighted_overlap / s.labelled_images;
    s.over += image.scores.over / s.labelled_images;
    s.under += image.scores.under / s.labelled_images;
    s.under_error += image.scores.under_error / s.labelled_images;
  }
  s.recall_50 = ClusterRate(recall_50);
  s.recall_75 = ClusterRate(recall_75);
  s.precision_50 = ClusterRate(precision_50);
  s.precision_75 = ClusterRate(precision_75);
  s.segments = found > 0 ? static_cast<double>(pieces) / found : 0;
  return s;
}

struct NamedRate {
  const char *key, *name;
  ReportRate Statistics::*rate;
};
constexpr NamedRate kRates[] = {
    {"recall_50", "recall, IoU over .5, %", &Statistics::recall_50},
    {"recall_75", "recall, IoU from .75, %", &Statistics::recall_75},
    {"precision_50", "precision, IoU over .5, %", &Statistics::precision_50},
    {"precision_75", "precision, IoU from .75, %", &Statistics::precision_75},
};

struct NamedMean {
  const char *key, *name;
  double Statistics::*mean;
  bool is_share;
};
constexpr NamedMean kMeans[] = {
    {"weighted_overlap", "weighted overlap, %", &Statistics::weighted_overlap, true},
    {"over", "over-segmentation, %", &Statistics::over, true},
    {"under", "under-segmentation, %", &Statistics::under, true},
    {"under_error", "under-segmentation error, %", &Statistics::under_error, true},
    {"segments_per_instance", "segments per instance", &Statistics::segments, false},
};

}  // namespace

std::string SegmentationTable(std::span<const SegmentationRow> rows) {
  std::vector<std::vector<std::string>> columns{{"", "images"}};
  for (const NamedRate& rate : kRates) columns.front().push_back(rate.name);
  for (const NamedMean& mean : kMeans) columns.front().push_back(mean.name);
  columns.front().push_back("seconds per image");
  for (const SegmentationRow& row : rows) {
    const Statistics s = StatisticsOf(row);
    std::vector<std::string>& column = columns.emplace_back();
    column = {row.method, fmt::format("{}", s.images)};
    for (const NamedRate& rate : kRates) {
      const ReportRate& value = s.*rate.rate;
      column.push_back(value.samples == 0 ? "-"
                                          : fmt::format("{} {}", PercentNumber(value.rate()),
                                                        IntervalText(value.ci95)));
    }
    for (const NamedMean& mean : kMeans) {
      const double value = s.*mean.mean;
      column.push_back(s.labelled_images == 0 ? "-"
                       : mean.is_share        ? PercentNumber(value)
                                              : fmt::format("{:.2f}", value));
    }
    column.push_back(fmt::format("{:.3f}", s.seconds));
  }
  std::string text;
  for (size_t line = 0; line < columns.front().size(); ++line) {
    for (const std::vector<std::string>& column : columns) {
      size_t width = 0;
      for (const std::string& cell : column) width = std::max(width, cell.size());
      text += fmt::format("{:<{}}  ", column[line], width);
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  return text;
}

std::string SegmentationJson(std::span<const SegmentationRow> rows) {
  nlohmann::ordered_json methods = nlohmann::ordered_json::array();
  for (const SegmentationRow& row : rows) {
    const Statistics s = StatisticsOf(row);
    nlohmann::ordered_json method{{"method", row.method}, {"images", s.images}};
    for (const NamedRate& rate : kRates) {
      const ReportRate& value = s.*rate.rate;
      method[rate.key] = value.rate();
      method[fmt::format("{}_samples", rate.key)] = value.samples;
      AddInterval(method, fmt::format("{}_ci95", rate.key), value.ci95);
    }
    for (const NamedMean& mean : kMeans) {
      method[mean.key] = s.labelled_images > 0 ? nlohmann::ordered_json(s.*mean.mean) : nullptr;
    }
    methods.push_back(std::move(method));
  }
  return nlohmann::ordered_json{{"methods", methods}}.dump(2) + "\n";
}

ResultColumns SegmentScoresColumns() {
  return {
      {"method", "name of the segmentation method"},
      {"image", "trial of the scenario, or name of the cloud"},
      {"segments", "number of segments"},
      {"instances", "number of labelled instances with a depth reading"},
      {"matched_50", "number of segments with an IoU over .5 with an instance"},
      {"matched_75", "number of segments with an IoU of at least .75 with an instance"},
      {"weighted_overlap", "mean IoU of the instances, weighted by their pixels", "0..1"},
      {"over", "over-segmentation: pixels of instances outside their representing segment", "0..1"},
      {"under", "under-segmentation: foreign pixels of the representing segments", "0.."},
      {"under_error", "under-segmentation error of Neubert and Protzel", "0.."},
  };
}

std::string SegmentScoresCsv(std::span<const SegmentationRow> rows) {
  std::string csv = HeaderLine(SegmentScoresColumns());
  for (const SegmentationRow& row : rows) {
    for (const SegmentedImage& image : row.images) {
      const SegmentScores& s = image.scores;
      csv += fmt::format("{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f}\n", row.method,
                         CsvCell(image.name), s.segments, s.instances.size(), s.matched_50,
                         s.matched_75, s.weighted_overlap, s.over, s.under, s.under_error);
    }
  }
  return csv;
}

ResultColumns SegmentsColumns() {
  return {
      {"method", "name of the segmentation method"},
      {"image", "trial of the scenario, or name of the cloud"},
      {"label", "label of the instance; in a scenario the instance + 1"},
      {"pixels", "pixels of the instance with a depth reading", "px"},
      {"counted", "1 = the instance counts for recall", "0 or 1"},
      {"iou", "largest IoU with a segment", "0..1"},
      {"segments", "number of segments that cover this instance more than others"},
      {"in_segment", "share of the instance inside its representing segment", "0..1"},
  };
}

std::string SegmentsCsv(std::span<const SegmentationRow> rows) {
  std::string csv = HeaderLine(SegmentsColumns());
  for (const SegmentationRow& row : rows) {
    for (const SegmentedImage& image : row.images) {
      for (const SegmentedInstance& instance : image.scores.instances) {
        csv += fmt::format("{},{},{},{},{},{:.4f},{},{:.4f}\n", row.method, CsvCell(image.name),
                           instance.label, instance.pixels, static_cast<int>(instance.is_counted),
                           instance.iou, instance.segments, instance.in_segment);
      }
    }
  }
  return csv;
}

}  // namespace pickbed::eval
