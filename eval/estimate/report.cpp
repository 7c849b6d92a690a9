#include "eval/estimate/report.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/estimate/statistics.h"
#include "eval/metrics/metric_columns.h"
#include "eval/metrics/pose_columns.h"
#include "eval/page/vega.h"

namespace pickbed::eval {
namespace {

std::string BandName(const RecallBand& band) {
  return VisibleBand{band.visible_min, band.visible_max}.name() + " %";
}

std::string RecallOf(const RecallBand& band) {
  if (band.instances == 0) return "-";
  return PercentNumber(static_cast<double>(band.recalled) / band.instances);
}

// Name and formatted value of a statistic.
struct NamedStatistic {
  std::string name, value;
};

std::vector<NamedStatistic> StatisticList(const ComparedRow& row, const ComparisonStatistics& f) {
  std::vector<NamedStatistic> list{
      {"top-ranked pose right, %",
       fmt::format("{} ({} of {})", PercentNumber(f.bins > 0 ? 1.0 * f.top_right / f.bins : 0),
                   f.top_right, f.bins)},
      {fmt::format("{} top-ranked poses right, %", kTopPoses),
       f.top5_bins > 0
           ? fmt::format("{} ({} of {})", PercentNumber(1.0 * f.top5_right / f.top5_bins),
                         f.top5_right, f.top5_bins)
           : "-"},
      {"recall, %",
       fmt::format("{} ({} of {})", PercentNumber(f.recall()), f.recalled, f.instances)}};
  if (f.top_pick_chance) {
    list.insert(list.begin() + 1,
                {"mean predicted pick probability, %", PercentNumber(*f.top_pick_chance)});
  }
  for (const RecallBand& band : f.bands) {
    list.push_back({"  recall, " + BandName(band) + " visible", RecallOf(band)});
  }
  const std::vector<NamedStatistic> rest{
      {"precision, %",
       fmt::format("{} ({} of {})", PercentNumber(f.precision()), f.right, f.poses)},
      {"recall at precision 0.95, %", PercentNumber(f.recall_at_95)},
      {"right object, %", PercentNumber(f.poses > 0 ? 1.0 * f.identity_right / f.poses : 0)},
      {"median rotation error, deg", MedianText(f.median_rotation_deg, 2)},
      {"median MSSD, diameters", MedianText(f.median_mssd_diameters, 4)},
      {"rotation error over 15 deg, %", PercentNumber(f.share_over_15_deg)},
      {"calibration error (ECE)", fmt::format("{:.3f}", f.calibration_error)},
      {"AR (VSD, MSSD, MSPD)", fmt::format("{:.3f}", row.bop.ar())},
      {"  AR VSD", fmt::format("{:.3f}", row.bop.ar_vsd)},
      {"  AR MSSD", fmt::format("{:.3f}", row.bop.ar_mssd)},
      {"  AR MSPD", fmt::format("{:.3f}", row.bop.ar_mspd)},
      {"AP (MSSD, MSPD)", fmt::format("{:.3f}", row.bop.ap())},
      {"seconds per image", fmt::format("{:.3f}", f.seconds)},
      {"maximum memory, MiB", fmt::format("{:.0f}", row.peak_memory_mib)},
      {"seconds to load", fmt::format("{:.1f}", row.setup_s)}};
  list.insert(list.end(), rest.begin(), rest.end());
  return list;
}

// Header, then one line per statistic. One column per estimator.
std::vector<std::vector<std::string>> StatisticTable(const std::vector<ComparedRow>& rows) {
  std::vector<std::vector<std::string>> table{{""}};
  for (const ComparedRow& row : rows) {
    table.front().push_back(row.label);
    const std::vector<NamedStatistic> list = StatisticList(row, StatisticsOf(row));
    for (size_t i = 0; i < list.size(); ++i) {
      if (table.size() <= i + 1) table.push_back({list[i].name});
      table[i + 1].push_back(list[i].value);
    }
  }
  return table;
}

std::vector<std::vector<std::string>> FamilyTable(const std::vector<ComparedRow>& rows,
                                                  const ObjectSet& objects) {
  std::vector<std::vector<std::string>> table{{"object"}};
  for (const auto& object : objects) table.push_back({object->name});
  for (const ComparedRow& row : rows) {
    table.front().push_back(row.label);
    for (size_t i = 0; i < objects.size(); ++i) {
      table[i + 1].push_back(PercentNumber(StatisticsOf(row, ObjectId(i)).recall()));
    }
  }
  return table;
}

std::vector<std::vector<std::string>> StageTable(const std::vector<ComparedRow>& rows) {
  constexpr std::string_view kPrefix = "estimate/";
  std::vector<std::vector<std::string>> table{
      {"estimator", "stage", "seconds per image", "share, %"}};
  for (const ComparedRow& row : rows) {
    const ComparisonStatistics statistics = StatisticsOf(row);
    for (const auto& [stage, seconds] : statistics.stages) {
      if (!stage.starts_with(kPrefix)) continue;
      table.push_back({row.label, stage.substr(kPrefix.size()), fmt::format("{:.4f}", seconds),
                       PercentNumber(seconds / statistics.seconds)});
    }
  }
  return table;
}

// Recall in each visible-fraction band, with its 95 % interval over bins.
RateCurve RecallCurve(const ComparedRow& row) {
  std::vector<std::vector<Cluster>> bins(EmptyRecallBands().size());  // by band
  for (const ComparedImage& image : row.images) {
    std::vector<RecallBand> here = EmptyRecallBands();
    for (const InstanceRecord& instance : image.score.instances) CountRecall(instance, here);
    for (size_t b = 0; b < here.size(); ++b)
      bins[b].push_back({here[b].recalled, here[b].instances});
  }
  RateCurve curve{row.label, {}};
  for (const std::vector<Cluster>& band : bins) curve.rates.push_back(ClusterRate(band));
  return curve;
}

CalibrationCurve ReliabilityCurve(const ComparedRow& row) {
  const std::vector<ReliabilityBin> reliability = StatisticsOf(row).reliability;
  std::vector<std::vector<Cluster>> by_image(reliability.size());
  for (const ComparedImage& image : row.images) {
    ComparedRow one_image;
    one_image.images = {image};
    const std::vector<ReliabilityBin> here = StatisticsOf(one_image).reliability;
    for (size_t b = 0; b < here.size(); ++b) by_image[b].push_back({here[b].right, here[b].count});
  }
  CalibrationCurve curve{row.label, {}};
  for (size_t b = 0; b < reliability.size(); ++b) {
    if (reliability[b].count == 0) continue;
    curve.points.push_back(
        {reliability[b].score_sum / reliability[b].count, ClusterRate(by_image[b])});
  }
  return curve;
}

ReportChart RecallChart(const std::vector<ComparedRow>& rows) {
  std::vector<std::string> bands;
  for (const RecallBand& band : EmptyRecallBands()) bands.push_back(BandName(band));
  std::vector<RateCurve> curves;
  for (const ComparedRow& row : rows) curves.push_back(RecallCurve(row));
  return RateCurves({"recall", "Recall by visible fraction", "Bars: 95 % intervals over bins.", ""},
                    "visible fraction of the instance", "recall", bands, curves);
}

ReportChart ReliabilityChart(const std::vector<ComparedRow>& rows) {
  std::vector<CalibrationCurve> curves;
  for (const ComparedRow& row : rows) curves.push_back(ReliabilityCurve(row));
  ReportChart chart{"reliability", "Calibration of the score",
                    "Share of right poses among those with about the same score. On the dotted "
                    "line it equals the score. Bars: 95 % intervals over bins.",
                    ""};
  chart.table = {{"estimator", "mean score", "right [95 %]", "poses"}};
  return CalibrationCurves(std::move(chart), "score", "share right", curves);
}

MetricColumns PlacedMetrics() { return MetricColumns::Placed(MetricUnits::kStored, {kMssd_m}); }

}  // namespace

ResultColumns EstimatorComparisonColumns() {
  ResultColumns columns{
      {"estimator", "estimator as given on the command line"},
      {"object", "name of the object, or all"},
      {"bins", "number of images, one per bin"},
      {"top_right", "number of images whose highest-ranked pose is correct"},
      {"top5_right",
       "number of images whose 5 highest-ranked poses are correct; needs 5 instances"},
      {"instances", "number of instances with a visible fraction of at least 0.1"},
      {"recalled", "number of these instances with a correct pose"},
      {"poses", "number of reported poses"},
      {"right", "number of correct poses, at most one per instance"},
      {"identity_right", "number of poses whose nearest instance is of the named object"},
      {"recall_at_95", "largest recall at a score threshold with a precision of 0.95", "0..1"},
      {"median_rotation_deg", "median rotation error of roughly matched poses"},
      {"median_rotation_low", "lower end of its 95 % interval", "deg"},
      {"median_rotation_high", "upper end of its 95 % interval", "deg"},
      {"median_mssd_diameters", "median MSSD of roughly matched poses"},
      {"median_mssd_low", "lower end of its 95 % interval", "diameters"},
      {"median_mssd_high", "upper end of its 95 % interval", "diameters"},
      {"share_over_15_deg", "share of roughly matched poses with a rotation error over 15 degrees",
       "0..1"},
      {"calibration_error", "expected calibration error of the score, ten bins", "0..1"},
  };
  for (const RecallBand& band : EmptyRecallBands()) {
    const int low = static_cast<int>(100 * band.visible_min + 0.5);
    const int high = static_cast<int>(100 * band.visible_max + 0.5);
    AddColumns({{fmt::format("instances_{}_{}", low, high),
                 fmt::format("number of instances that are {} to {} % visible", low, high)},
                {fmt::format("recalled_{}_{}", low, high), "number of these with a correct pose"}},
               columns);
  }
  AddColumns({{"ar_vsd", "BOP19 average recall by VSD", "0..1"},
              {"ar_mssd", "BOP19 average recall by MSSD", "0..1"},
              {"ar_mspd", "BOP19 average recall by MSPD", "0..1"},
              {"ap_mssd", "BOP24 average precision by MSSD", "0..1"},
              {"ap_mspd", "BOP24 average precision by MSPD", "0..1"},
              {"top_pick_chance",
               "mean predicted probability that a pick at the highest-ranked pose succeeds; empty "
               "without tolerance maps",
               "0..1"}},
             columns);
  return columns;
}

ResultColumns HypothesesColumns() {
  ResultColumns columns{
      {"estimator", "estimator as given on the command line"},
      {"trial", "number of the trial"},
      {"hypothesis", "number of the hypothesis in its image, highest score first"},
      {"object", "name of the object"},
      {"instance", "matched instance, -1 = none"},
      {"score", "score of the pose; calibrated estimators: probability that it is correct"},
  };
  AddColumns(PlacedMetrics().Columns(), columns);
  AddColumns(
      {{"correct", "1 if the MSSD is under a tenth of the object's diameter"},
       {"p_pick",
        "predicted probability that a pick at this pose succeeds; empty without tolerance maps",
        "0..1"}},
      columns);
  AddColumns(PoseColumns("estimated pose"), columns);
  AddColumns(MetricColumns::AtEnd(MetricUnits::kStored).Columns(), columns);
  return columns;
}

std::string ComparisonTable(const std::vector<ComparedRow>& rows) {
  constexpr size_t kMinWidth = 26;
  const std::vector<std::vector<std::string>> table = StatisticTable(rows);
  std::string text;
  for (const std::vector<std::string>& line : table) {
    text += fmt::format("{:<32}", line.front());
    for (size_t i = 1; i < line.size(); ++i) {
      const size_t width = std::max(kMinWidth, table.front()[i].size() + 1);
      text += fmt::format("{:>{}}", line[i], width);
    }
    text += "\n";
  }
  return text;
}

std::string ComparisonCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects) {
  std::string csv = HeaderLine(EstimatorComparisonColumns());
  for (const ComparedRow& row : rows) {
    for (ObjectId object = kAnyObject; object < static_cast<int>(objects.size()); ++object) {
      const bool all = object < 0;
      const ComparisonStatistics f = all ? StatisticsOf(row) : StatisticsOf(row, object);
      csv +=
          fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}", row.label,
                      all ? "all" : objects[object]->name, f.bins, f.top_right, f.top5_right,
                      f.instances, f.recalled, f.poses, f.right, f.identity_right, f.recall_at_95,
                      MedianCells(f.median_rotation_deg), MedianCells(f.median_mssd_diameters),
                      f.share_over_15_deg, f.calibration_error);
      for (const RecallBand& band : f.bands) {
        csv += fmt::format(",{},{}", band.instances, band.recalled);
      }
      const auto known = row.bop.objects.find(object + 1);
      const ObjectScores of_object =
          known != row.bop.objects.end() ? known->second : ObjectScores();
      csv += fmt::format(
          ",{},{},{},{},{},{}\n", all ? row.bop.ar_vsd : of_object.ar_vsd,
          all ? row.bop.ar_mssd : of_object.ar_mssd, all ? row.bop.ar_mspd : of_object.ar_mspd,
          all ? row.bop.ap_mssd : of_object.ap_mssd, all ? row.bop.ap_mspd : of_object.ap_mspd,
          f.top_pick_chance ? fmt::format("{:.4f}", *f.top_pick_chance) : "");
    }
  }
  return csv;
}

std::string HypothesesCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects) {
  const MetricColumns placed = PlacedMetrics(), at_end = MetricColumns::AtEnd(MetricUnits::kStored);
  std::string csv = HeaderLine(HypothesesColumns());
  for (const ComparedRow& row : rows) {
    for (const ComparedImage& image : row.images) {
      for (size_t i = 0; i < image.score.hypotheses.size(); ++i) {
        const HypothesisRecord& h = image.score.hypotheses[i].record;
        const bool known = !image.pick_chances.empty() && image.pick_chances[i].has_value();
        csv += fmt::format("{},{},{},{},{},{}{},{},{}{}{}\n", row.label, image.trial, i,
                           objects[h.object]->name, h.instance, h.score, placed.Cells(h.metrics),
                           h.correct ? 1 : 0,
                           known ? fmt::format("{:.4f}", *image.pick_chances[i]) : "",
                           PoseCells(h.X_WO), at_end.Cells(h.metrics));
      }
    }
  }
  return csv;
}

ResultColumns EstimatedInstancesColumns() {
  return {
      {"estimator", "estimator as given on the command line"},
      {"trial", "number of the trial"},
      {"instance", "number of the instance in its bin"},
      {"object", "name of the object"},
      {"visible_fraction", "visible share of its pixels; recall counts from 0.1 on", "0..1"},
      {"found", "1 if a reported pose is correct for it"},
  };
}

std::string InstancesCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects) {
  std::string csv = HeaderLine(EstimatedInstancesColumns());
  for (const ComparedRow& row : rows) {
    for (const ComparedImage& image : row.images) {
      for (const InstanceRecord& instance : image.score.instances) {
        csv += fmt::format("{},{},{},{},{},{}\n", row.label, image.trial, instance.instance,
                           objects[instance.object]->name, instance.visible_fraction,
                           instance.recalled ? 1 : 0);
      }
    }
  }
  return csv;
}

HtmlPage ComparisonPage(const std::string& title, const std::vector<ComparedRow>& rows,
                        const ObjectSet& objects, const std::vector<std::string>& pictures) {
  HtmlPage page(title);
  page.Paragraph(
      "Each estimator got the same images. A pose is right if its MSSD is under a tenth of the "
      "object's diameter. Instances at least 10 % visible are to be found; a second pose of an "
      "instance is wrong. Bands, and brackets after medians, are 95 % intervals over bins, because "
      "the poses in one image are not independent.");
  page.Table(StatisticTable(rows));
  page.Heading("Curves");
  page.Charts({RecallChart(rows), ReliabilityChart(rows)});
  if (objects.size() > 1) {
    page.Heading("Recall by object, %");
    page.Table(FamilyTable(rows, objects));
  }
  page.Heading("Time per stage");
  page.Table(StageTable(rows));
  if (!pictures.empty()) page.Heading("The first bins");
  for (const std::string& picture : pictures) page.Picture(picture, picture);
  return page;
}

}  // namespace pickbed::eval
