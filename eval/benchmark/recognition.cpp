#include "eval/benchmark/recognition.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <regex>
#include <set>

#include "eval/estimate/statistics.h"
#include "eval/stats/paired_tests.h"
#include "eval/summary/run_summary.h"
#include "perception/completion/shape_completer.h"
#include "scenes/base/error.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {
namespace {

constexpr double kTiny = 1e-9;
// Bins of a scenario before the next scenario. So an interrupted benchmark has bins of each.
constexpr int kRoundBins = 2;
// Images of the gallery that gained instances, and that lost some.
constexpr int kGalleryImages = 3;

RecognitionBin RecognitionOf(const std::string& scenario, const std::string& completion,
                             const ComparedRow& row, const ComparedImage& image) {
  const ComparisonStatistics statistics = StatisticsOf(ComparedRow{row.label, {image}, {}, 0, 0});
  RecognitionBin bin{
      scenario,          completion, image.trial, {}, {statistics.right, statistics.poses},
      statistics.seconds};
  for (const RecallBand& band : statistics.bands) {
    bin.bands.push_back({band.recalled, band.instances});
  }
  return bin;
}

// Contributions of the bins with one completion, in their order.
template <typename ClusterOf>
std::vector<Cluster> Clusters(const Recognition& recognition, const std::string& completion,
                              const std::string& scenario, ClusterOf cluster_of) {
  std::vector<Cluster> clusters;
  for (const RecognitionBin& bin : recognition.bins) {
    if (bin.completion != completion) continue;
    if (!scenario.empty() && bin.scenario != scenario) continue;
    clusters.push_back(cluster_of(bin));
  }
  return clusters;
}

template <typename ClusterOf>
RecognitionChange ChangeOf(const Recognition& recognition, const std::string& completion,
                           const std::string& scenario, ClusterOf cluster_of) {
  const auto before = Clusters(recognition, recognition.completions.front(), scenario, cluster_of);
  const auto after = Clusters(recognition, completion, scenario, cluster_of);
  return {ClusterRate(before), ClusterRate(after), PairedInterval(before, after),
          PairedRateTest(before, after)};
}

double MeanEstimateSeconds(const Recognition& recognition, const std::string& completion) {
  double sum = 0;
  int count = 0;
  for (const RecognitionBin& bin : recognition.bins) {
    if (bin.completion != completion) continue;
    sum += bin.seconds;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

std::vector<std::string> ScenariosOf(const Recognition& recognition) {
  std::vector<std::string> names;
  for (const RecognitionBin& bin : recognition.bins) {
    if (std::find(names.begin(), names.end(), bin.scenario) == names.end()) {
      names.push_back(bin.scenario);
    }
  }
  return names;
}

// One row of the tables: a completion, and the instances whose recall it has.
struct ChangeRow {
  std::string completion, scenario;  // an empty scenario = all
  double from, to;                   // visible fraction
};

std::vector<ChangeRow> ChangeRows(const Recognition& recognition) {
  std::vector<ChangeRow> rows;
  for (size_t i = 1; i < recognition.completions.size(); ++i) {
    const std::string& completion = recognition.completions[i];
    for (const RecallBand& band : EmptyRecallBands()) {
      rows.push_back({completion, "", band.visible_min, band.visible_max});
    }
    rows.push_back({completion, "", kOccludedFrom, kOccludedTo});
    for (const std::string& scenario : ScenariosOf(recognition)) {
      rows.push_back({completion, scenario, kOccludedFrom, kOccludedTo});
    }
  }
  return rows;
}

// The p value of few bins says nothing.
std::string PText(const RecognitionChange& change) {
  return change.difference.is_known() ? fmt::format("{:.3f}", change.p) : "-";
}

std::string VisibleText(const ChangeRow& row) {
  return fmt::format("{:.0f}-{:.0f} %", 100 * row.from, 100 * row.to);
}

TableCells RecallTable(const Recognition& recognition) {
  const std::string& reference = recognition.completions.front();
  TableCells table{{"completion", "scenario", "visible", "recall with " + reference,
                    "recall with the completion", "difference, points", "p"}};
  for (const ChangeRow& row : ChangeRows(recognition)) {
    const RecognitionChange change =
        RecallChange(recognition, row.completion, row.from, row.to, row.scenario);
    table.push_back({row.completion, row.scenario.empty() ? "all" : row.scenario, VisibleText(row),
                     RateText(change.reference), RateText(change.rate),
                     PointsText(change.rate.rate() - change.reference.rate(), change.difference),
                     PText(change)});
  }
  return table;
}

TableCells PrecisionTable(const Recognition& recognition) {
  TableCells table{{"completion", "precision", "difference, points", "p", "seconds an image"}};
  for (const std::string& completion : recognition.completions) {
    const RecognitionChange change = PrecisionChange(recognition, completion);
    const bool is_reference = completion == recognition.completions.front();
    table.push_back(
        {completion, RateText(change.rate),
         is_reference ? "-"
                      : PointsText(change.rate.rate() - change.reference.rate(), change.difference),
         is_reference ? "-" : PText(change),
         fmt::format("{:.2f}", MeanEstimateSeconds(recognition, completion))});
  }
  return table;
}

// Chooses the images of the gallery while they are estimated.
class GalleryChoice {
 public:
  // Returns whether the gallery shows an image with this change.
  bool Takes(const RecalledChange& change) {
    const bool gains = change.gained > 0 && gained_ < kGalleryImages;
    const bool loses = change.lost > 0 && lost_ < kGalleryImages;
    if (!is_first_ && !gains && !loses) return false;
    is_first_ = false;
    gained_ += gains;
    lost_ += loses;
    return true;
  }

 private:
  bool is_first_ = true;
  int gained_ = 0, lost_ = 0;
};

// A round of bins of a scenario.
struct Round {
  std::string scenario;
  int scenario_index = 0;  // in RecognitionOptions::scenarios
  int first = 0;           // bin
  int bins = 0;
};

// Returns the folder of the pictures of a round. Scenario files can have the same name, so it has
// the index of the scenario, too.
std::string PicturesFolder(const Round& round) {
  return fmt::format("{}_{}_{:03}", std::filesystem::path(round.scenario).stem().string(),
                     round.scenario_index, round.first);
}

// Removes the pictures of an earlier benchmark in the same results folder.
void RemovePictures(const std::filesystem::path& pictures) {
  static const std::regex written(".+_[0-9]{3,}");
  std::vector<std::filesystem::path> folders;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(pictures, none)) {
    if (entry.is_directory() && std::regex_match(entry.path().filename().string(), written)) {
      folders.push_back(entry.path());
    }
  }
  for (const std::filesystem::path& folder : folders) std::filesystem::remove_all(folder);
}

// Estimates one round. Adds its pictures to the gallery.
std::vector<ComparedRow> ComparedRound(const RecognitionOptions& options, const Round& round,
                                       const std::function<bool(int done)>& on_bin,
                                       GalleryChoice& choice,
                                       std::vector<RecognitionPictures>& gallery) {
  ScenarioRequest request;
  request.scenario = round.scenario;
  request.trials = round.bins;
  LoadedScenario scenario = FindScenario(request);
  scenario.spec.seed = options.seed + static_cast<uint64_t>(round.first);
  scenario.spec.estimator.mode = options.mode;
  ComparisonJob job{scenario.spec, scenario.objects, {}, {}, 0, 1, {}, {}};
  for (const std::string& completion : options.completions) {
    EstimatorSpec estimator = scenario.spec.estimator;
    estimator.completion = completion;
    estimator.completion_model = options.model;
    job.estimators.push_back({completion, estimator});
  }
  bool goes_on = true;
  job.on_progress = [&](std::string_view what, int done, int) {
    if (what == "bin") goes_on = on_bin(done);
  };
  job.stop = [&] { return !goes_on; };
  if (!options.pictures.empty()) {
    const std::filesystem::path folder = PicturesFolder(round);
    job.out = options.pictures / folder;
    job.wants_pictures = [&, folder](const std::vector<const ComparedImage*>& images) {
      const ComparedImage &before = *images.front(), &after = *images.back();
      const RecalledChange change = ChangeInImage(before.score.instances, after.score.instances);
      if (!choice.Takes(change)) return false;
      gallery.push_back({round.scenario, round.first + before.trial, change,
                         ComparedOverlay(folder, before.trial, options.completions.front()),
                         ComparedOverlay(folder, before.trial, options.completions.back())});
      return true;
    };
  }
  return CompareEstimators(job);
}

}  // namespace

RecalledChange ChangeInImage(const std::vector<InstanceRecord>& before,
                             const std::vector<InstanceRecord>& after) {
  assert(before.size() == after.size());
  RecalledChange change;
  for (size_t i = 0; i < before.size(); ++i) {
    if (before[i].visible_fraction < kCountedVisibility) continue;
    const bool was = before[i].recalled, is = after[i].recalled;
    ++change.instances;
    change.recalled_before += was;
    change.recalled_after += is;
    change.gained += is && !was;
    change.lost += was && !is;
  }
  return change;
}

void CheckRecognition(const RecognitionOptions& options) {
  const std::set<std::string> distinct(options.completions.begin(), options.completions.end());
  CheckInput(options.completions.size() >= 2 && distinct.size() == options.completions.size(),
             "name at least two completions, and each only once");
  std::vector<std::string> known = perception::CompleterNames();
  known.insert(known.begin(), kNoCompletion);
  for (const std::string& completion : options.completions) {
    CheckInput(std::ranges::find(known, completion) != known.end(),
               UnknownNameMessage("completion method", completion, known));
  }
  for (const std::string& name : options.scenarios) {
    ScenarioRequest request;
    request.scenario = name;
    FindScenario(request);
  }
}

Recognition RunRecognition(const RecognitionOptions& options,
                           const std::function<bool(int done, int total)>& on_progress) {
  CheckRecognition(options);
  if (!options.pictures.empty()) RemovePictures(options.pictures);
  Recognition recognition;
  recognition.completions = options.completions;
  const int total = options.bins * static_cast<int>(options.scenarios.size());
  int done = 0;
  bool stops = false;
  GalleryChoice choice;
  for (int first = 0; first < options.bins && !stops; first += kRoundBins) {
    for (size_t scenario = 0; scenario < options.scenarios.size() && !stops; ++scenario) {
      const std::string& name = options.scenarios[scenario];
      const int bins = std::min(kRoundBins, options.bins - first);
      if (on_progress && !on_progress(done, total)) return recognition;
      const auto on_bin = [&](int bins_done) {
        if (on_progress && !on_progress(done + bins_done, total)) stops = true;
        return !stops;
      };
      const std::vector<ComparedRow> rows =
          ComparedRound(options, {name, static_cast<int>(scenario), first, bins}, on_bin, choice,
                        recognition.gallery);
      for (size_t image = 0; image < rows.front().images.size(); ++image) {
        for (size_t i = 0; i < rows.size(); ++i) {
          recognition.bins.push_back(
              RecognitionOf(name, options.completions[i], rows[i], rows[i].images[image]));
          recognition.bins.back().bin += first;
        }
      }
      done += bins;
    }
  }
  return recognition;
}

RecognitionChange RecallChange(const Recognition& recognition, const std::string& completion,
                               double from, double to, const std::string& scenario) {
  const std::vector<RecallBand> ranges = EmptyRecallBands();
  return ChangeOf(recognition, completion, scenario, [&](const RecognitionBin& bin) {
    Cluster sum;
    for (size_t i = 0; i < ranges.size() && i < bin.bands.size(); ++i) {
      if (ranges[i].visible_min < from - kTiny || ranges[i].visible_max > to + kTiny) continue;
      sum.hits += bin.bands[i].hits;
      sum.samples += bin.bands[i].samples;
    }
    return sum;
  });
}

RecognitionChange PrecisionChange(const Recognition& recognition, const std::string& completion) {
  return ChangeOf(recognition, completion, "", [](const RecognitionBin& bin) { return bin.poses; });
}

std::string RecognitionText(const Recognition& recognition) {
  return AlignedText(RecallTable(recognition)) + "\n" + AlignedText(PrecisionTable(recognition));
}

ResultColumns RecognitionColumns() {
  return {{"completion", "method of completion"},
          {"scenario", "name of the scenario, empty = all"},
          {"visible_from", "smallest visible fraction of the instances", "0..1"},
          {"visible_to", "largest visible fraction of the instances", "0..1"},
          {"instances", "number of instances"},
          {"recalled_reference", "number of recalled instances without completion"},
          {"recalled", "number of recalled instances with completion"},
          {"difference", "difference of the recalls", "-1..1"},
          {"difference_low", "lower end of its 95 % interval, paired by bin", "-1..1"},
          {"difference_high", "upper end of its 95 % interval, paired by bin", "-1..1"},
          {"p", "p value of a paired sign-flip test over bins", "0..1"}};
}

std::string RecognitionCsv(const Recognition& recognition) {
  std::string csv = HeaderLine(RecognitionColumns());
  for (const ChangeRow& row : ChangeRows(recognition)) {
    const RecognitionChange change =
        RecallChange(recognition, row.completion, row.from, row.to, row.scenario);
    csv += fmt::format("{},{},{:.2f},{:.2f},{},{},{},{:.4f},{},{:.4f}\n", row.completion,
                       CsvCell(row.scenario), row.from, row.to, change.rate.samples,
                       change.reference.hits, change.rate.hits,
                       change.rate.rate() - change.reference.rate(),
                       IntervalCells(change.difference, 4), change.p);
  }
  return csv;
}

ResultColumns RecognitionBinsColumns() {
  return {{"scenario", "name of the scenario"},
          {"bin", "index of the bin"},
          {"completion", "method of completion"},
          {"visible_from", "smallest visible fraction of the instances", "0..1"},
          {"instances", "number of instances of this band"},
          {"recalled", "number of these that are recalled"},
          {"poses", "number of reported poses in the bin"},
          {"right", "number of these that are right"}};
}

std::string RecognitionBinsCsv(const Recognition& recognition) {
  const std::vector<RecallBand> ranges = EmptyRecallBands();
  std::string csv = HeaderLine(RecognitionBinsColumns());
  for (const RecognitionBin& bin : recognition.bins) {
    for (size_t i = 0; i < bin.bands.size(); ++i) {
      csv += fmt::format("{},{},{},{:.2f},{},{},{},{}\n", CsvCell(bin.scenario), bin.bin,
                         bin.completion, ranges[i].visible_min, bin.bands[i].samples,
                         bin.bands[i].hits, bin.poses.samples, bin.poses.hits);
    }
  }
  return csv;
}

void AddRecognition(const Recognition& recognition, const std::filesystem::path& pictures,
                    HtmlPage& page) {
  page.Heading("Recognition of known objects");
  page.Paragraph(
      "Recall of estimator descriptor on the same images, with additional poses from completed "
      "segments. Method skirt completes nothing: it has the seen surface only. So it shows what "
      "additional poses are worth without completion. 95 % intervals and p values are paired by "
      "bin.");
  page.Table(RecallTable(recognition));
  page.Table(PrecisionTable(recognition));
  if (recognition.gallery.empty()) return;
  const std::string &reference = recognition.completions.front(),
                    &completion = recognition.completions.back();
  page.Heading("Gallery of recognition");
  page.Paragraph(
      fmt::format("The first image, and images in which completion {} gained or lost instances. "
                  "On the left are the poses with {}, on the right those with {}.",
                  completion, reference, completion));
  for (const RecognitionPictures& images : recognition.gallery) {
    const RecalledChange& change = images.change;
    page.Subheading(fmt::format("{}, bin {}: {} gained, {} lost", images.scenario, images.bin,
                                change.gained, change.lost));
    const auto caption = [&](const std::string& name, int recalled) {
      return fmt::format("{}: {} of {} instances", name, recalled, change.instances);
    };
    page.Picture((pictures / images.without).string(), caption(reference, change.recalled_before));
    page.Picture((pictures / images.with).string(), caption(completion, change.recalled_after));
  }
}

}  // namespace pickbed::eval
