#include "eval/benchmark/completed_grasps.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "eval/draw/overlay.h"
#include "eval/trial/trial.h"
#include "grasp/planners/table.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {
namespace {

constexpr int kGalleryWidth_px = 900;

void SetPlanner(const std::string& name, const std::string& completion, ScenarioSpec& spec) {
  spec.planner.name = name;
  spec.planner.completion = completion;
  if (name != kTrueShapes) return;
  spec.planner.name = "completed";
  spec.planner.completion = kTrueShapes;
}

void RequirePlanners(const std::vector<std::string>& planners) {
  const std::set<std::string> distinct(planners.begin(), planners.end());
  CheckInput(!planners.empty() && distinct.size() == planners.size(),
             "name at least one planner, and each only once");
  for (const std::string& name : planners) {
    if (name == kTrueShapes) continue;
    CheckInput(
        !PlannerNamed(name).needs_poses,
        fmt::format("planner {} needs poses, but the shapes have no models; choose another", name));
  }
}

// Checks the options and returns the scenario with its pool.
LoadedScenario LoadedPool(const CompletedGraspsOptions& options) {
  RequirePlanners(options.planners);
  CheckInput(options.single + options.bins > 0, "no bins to pick; ask for single drops or bins");
  ScenarioRequest request;
  request.scenario = options.scenario;
  LoadedScenario scenario = FindScenario(request);
  CheckInput(scenario.spec.draw > 0,
             fmt::format("scenario {} draws no objects from a pool; choose one with draw",
                         options.scenario));
  return scenario;
}

bool IsSingle(const std::string& condition) { return condition == kGraspConditions[0]; }

// The scenario of a condition: a bin with one drawn shape and a single attempt, or the bins.
ScenarioSpec SpecOf(const std::string& condition, const ScenarioSpec& scenario,
                    const std::string& planner, const CompletedGraspsOptions& options) {
  ScenarioSpec spec = scenario;
  spec.seed = options.seed;
  SetPlanner(planner, options.completion, spec);
  if (IsSingle(condition)) {
    spec.draw = 1;
    spec.policy.max_attempts = 1;
  }
  return spec;
}

// Values of the shapes that the reference and the planner have tried, in the same order.
std::pair<std::vector<Cluster>, std::vector<Cluster>> Paired(
    const std::map<std::string, ShapeGrasps>& reference,
    const std::map<std::string, ShapeGrasps>& shapes, Cluster ShapeGrasps::*value) {
  std::pair<std::vector<Cluster>, std::vector<Cluster>> pairs;
  for (const auto& [shape, of_reference] : reference) {
    const auto found = shapes.find(shape);
    if (found == shapes.end()) continue;
    pairs.first.push_back(of_reference.*value);
    pairs.second.push_back(found->second.*value);
  }
  return pairs;
}

// Without an executed grasp of one planner, there is no difference.
bool HasDifference(const CompletedGrasps& grasps, const std::string& condition,
                   const std::string& planner) {
  const auto executed = [&](const std::string& name) {
    return GraspRateOf(grasps, condition, name, &ShapeGrasps::grasps).rate.samples;
  };
  return executed(planner) > 0 && executed(grasps.planners.front()) > 0;
}

// The p value of few bins says nothing.
std::string PText(const PairedStatistic& statistic) {
  return statistic.difference_ci95.is_known() ? fmt::format("{:.3f}", statistic.p_value) : "-";
}

// One planner in the bins of a condition.
struct PlannerRun {
  std::unique_ptr<TrialRunner> runner;
  std::unique_ptr<GraspPictures> pictures;  // null: none
};

TableCells GraspTable(const CompletedGrasps& grasps) {
  TableCells table{{"condition", "planner", "instances picked", "difference in picked, points",
                    "grasps that succeed", "difference in success, points", "p of success",
                    "shapes"}};
  for (const char* condition : kGraspConditions) {
    for (const std::string& planner : grasps.planners) {
      const auto& shapes = grasps.shapes.at(condition).at(planner);
      const GraspRate picked = GraspRateOf(grasps, condition, planner, &ShapeGrasps::picked);
      const GraspRate reference =
          GraspRateOf(grasps, condition, grasps.planners.front(), &ShapeGrasps::picked);
      const PairedStatistic success = SuccessDifference(grasps, condition, planner);
      const bool is_reference = planner == grasps.planners.front();
      const bool is_success_known = !is_reference && HasDifference(grasps, condition, planner);
      table.push_back(
          {condition, planner, RateText(picked.rate),
           is_reference ? "-"
                        : PointsText(picked.rate.rate() - reference.rate.rate(), picked.difference),
           RateText(GraspRateOf(grasps, condition, planner, &ShapeGrasps::grasps).rate),
           is_success_known ? DifferenceText(success) : "-",
           is_success_known ? PText(success) : "-", std::to_string(shapes.size())});
    }
  }
  return table;
}

}  // namespace

Cluster AddTrial(const TrialResult& trial, const std::vector<std::string>& names,
                 std::map<std::string, ShapeGrasps>& shapes) {
  Cluster sum;
  std::map<InstanceId, ShapeGrasps*> by_instance;
  for (const InstanceOutcome& outcome : trial.outcomes) {
    ShapeGrasps& shape = shapes[names.at(outcome.object)];
    by_instance[outcome.instance] = &shape;
    ++shape.picked.samples;
  }
  for (const AttemptRecord& attempt : trial.attempts) {
    const auto found = by_instance.find(attempt.matched_instance);
    if (!attempt.grasp || found == by_instance.end()) continue;
    const bool succeeded = attempt.failure == FailureReason::kNone;
    ++found->second->grasps.samples;
    found->second->grasps.hits += succeeded;
    found->second->picked.hits += succeeded;
    ++sum.samples;
    sum.hits += succeeded;
  }
  return sum;
}

void CheckCompletedGrasps(const CompletedGraspsOptions& options) { LoadedPool(options); }

CompletedGrasps RunCompletedGrasps(const CompletedGraspsOptions& options,
                                   const std::function<bool(int done, int total)>& on_progress) {
  const LoadedScenario scenario = LoadedPool(options);
  std::vector<std::string> names;
  for (const ObjectSpec& object : scenario.spec.objects) names.push_back(object.name);
  CompletedGrasps grasps;
  grasps.planners = options.planners;
  for (const char* condition : kGraspConditions) {
    for (const std::string& planner : options.planners) {
      grasps.shapes[condition][planner];
      grasps.bins[condition][planner];
    }
  }
  const int total = static_cast<int>(options.planners.size()) * (options.single + options.bins);
  int done = 0;
  for (const char* condition : kGraspConditions) {
    const bool is_single = IsSingle(condition);
    std::vector<ScenarioSpec> specs;
    for (const std::string& planner : options.planners) {
      specs.push_back(SpecOf(condition, scenario.spec, planner, options));
    }
    std::vector<PlannerRun> runs;
    for (const ScenarioSpec& spec : specs) {
      PlannerRun& run = runs.emplace_back();
      run.runner = std::make_unique<TrialRunner>(spec, scenario.objects);
      if (options.pictures) run.pictures = std::make_unique<GraspPictures>(spec);
    }
    const auto take_pictures = [&] {
      for (size_t i = 0; options.pictures && i < runs.size(); ++i) {
        grasps.gallery[condition][options.planners[i]] = runs[i].pictures->TakeTiles();
      }
    };
    // All planners pick a bin before the next one, so an interrupted benchmark is paired.
    for (int bin = 0; bin < (is_single ? options.single : options.bins); ++bin) {
      std::vector<TrialResult> trials;
      for (const PlannerRun& run : runs) {
        if (on_progress && !on_progress(done, total)) {
          take_pictures();
          return grasps;
        }
        trials.push_back(run.runner->Run(BinIndex(bin), run.pictures.get()));
        ++done;
      }
      for (size_t i = 0; i < runs.size(); ++i) {
        const std::string& planner = options.planners[i];
        grasps.bins[condition][planner].push_back(
            AddTrial(trials[i], names, grasps.shapes[condition][planner]));
      }
    }
    take_pictures();
  }
  if (on_progress) on_progress(total, total);
  return grasps;
}

GraspRate GraspRateOf(const CompletedGrasps& grasps, const std::string& condition,
                      const std::string& planner, Cluster ShapeGrasps::*value) {
  const auto& by_planner = grasps.shapes.at(condition);
  std::vector<Cluster> own;
  for (const auto& [shape, counts] : by_planner.at(planner)) own.push_back(counts.*value);
  const auto [reference, paired] =
      Paired(by_planner.at(grasps.planners.front()), by_planner.at(planner), value);
  return {ClusterRate(own), PairedInterval(reference, paired)};
}

PairedStatistic SuccessDifference(const CompletedGrasps& grasps, const std::string& condition,
                                  const std::string& planner) {
  const auto& by_planner = grasps.bins.at(condition);
  return PairedRate("success", "grasps that succeed", by_planner.at(grasps.planners.front()),
                    by_planner.at(planner));
}

std::string CompletedGraspsText(const CompletedGrasps& grasps) {
  return AlignedText(GraspTable(grasps));
}

ResultColumns CompletedGraspsColumns() {
  return {
      {"condition", "single: one shape in the bin, one attempt; bins: several shapes"},
      {"planner", "planner, or truth: completed with the true shapes"},
      {"shapes", "number of shapes"},
      {"dropped", "number of dropped instances"},
      {"picked", "number of these that were picked"},
      {"picked_low", "lower end of the 95 % interval of the rate, over shapes", "0..1"},
      {"picked_high", "upper end of the 95 % interval of the rate, over shapes", "0..1"},
      {"difference", "difference of the rate to the first planner", "-1..1"},
      {"difference_low", "lower end of its 95 % interval, paired by shape", "-1..1"},
      {"difference_high", "upper end of its 95 % interval, paired by shape", "-1..1"},
      {"executed", "number of executed grasps"},
      {"succeeded", "number of these that succeeded"},
      {"success_difference",
       "difference of their share to the first planner; empty without executed grasps", "-1..1"},
      {"success_difference_low", "lower end of its 95 % interval, paired by bin", "-1..1"},
      {"success_difference_high", "upper end of its 95 % interval, paired by bin", "-1..1"},
      {"success_p", "p value of the test of `pickbed compare`, paired by bin", "0..1"}};
}

std::string CompletedGraspsCsv(const CompletedGrasps& grasps) {
  std::string csv = HeaderLine(CompletedGraspsColumns());
  for (const char* condition : kGraspConditions) {
    const ReportRate reference =
        GraspRateOf(grasps, condition, grasps.planners.front(), &ShapeGrasps::picked).rate;
    for (const std::string& planner : grasps.planners) {
      const GraspRate picked = GraspRateOf(grasps, condition, planner, &ShapeGrasps::picked);
      const ReportRate executed =
          GraspRateOf(grasps, condition, planner, &ShapeGrasps::grasps).rate;
      const PairedStatistic success = SuccessDifference(grasps, condition, planner);
      const std::string success_cells =
          HasDifference(grasps, condition, planner)
              ? fmt::format("{:.4f},{},{:.4f}", success.difference(),
                            IntervalCells(success.difference_ci95, 4), success.p_value)
              : ",,,";
      csv += fmt::format("{},{},{},{},{},{},{:.4f},{},{},{},{}\n", condition, planner,
                         grasps.shapes.at(condition).at(planner).size(), picked.rate.samples,
                         picked.rate.hits, IntervalCells(picked.rate.ci95, 4),
                         picked.rate.rate() - reference.rate(), IntervalCells(picked.difference, 4),
                         executed.samples, executed.hits, success_cells);
    }
  }
  return csv;
}

ResultColumns CompletedGraspsShapesColumns() {
  return {{"condition", "single or bins"},
          {"planner", "planner, or truth"},
          {"shape", "name of the shape"},
          {"dropped", "number of dropped instances"},
          {"picked", "number of these that were picked"},
          {"executed", "number of executed grasps"},
          {"succeeded", "number of these that succeeded"}};
}

std::string CompletedGraspsShapesCsv(const CompletedGrasps& grasps) {
  std::string csv = HeaderLine(CompletedGraspsShapesColumns());
  for (const char* condition : kGraspConditions) {
    for (const std::string& planner : grasps.planners) {
      for (const auto& [shape, counts] : grasps.shapes.at(condition).at(planner)) {
        csv += fmt::format("{},{},{},{},{},{},{}\n", condition, planner, CsvCell(shape),
                           counts.picked.samples, counts.picked.hits, counts.grasps.samples,
                           counts.grasps.hits);
      }
    }
  }
  return csv;
}

void AddCompletedGrasps(const std::filesystem::path& folder, const CompletedGrasps& grasps,
                        HtmlPage& page) {
  page.Heading("Grasps of unknown objects");
  page.Paragraph(
      "Picks in physics. Single: one shape in the bin, and one attempt. Bins: several shapes, "
      "picked by the policy of the scenario. All planners get the same bins. Row truth plans on "
      "the true shapes. 95 % intervals of rates are over shapes. Differences are to the first "
      "planner, paired by shape for picked instances and by bin for grasps. The test is the "
      "one of pickbed compare.");
  page.Table(GraspTable(grasps));
  if (grasps.gallery.empty()) return;
  page.Heading("Gallery of grasps");
  page.Paragraph(
      "The first grasps that succeeded and failed. From left to right: the segments of the image, "
      "the completed shape from the camera and from its side, and the hand at the grasp. A planner "
      "that completes no shapes has only the hand.");
  for (const char* condition : kGraspConditions) {
    const auto by_planner = grasps.gallery.find(condition);
    if (by_planner == grasps.gallery.end()) continue;  // not begun
    for (const std::string& planner : grasps.planners) {
      std::vector<Image<Rgb8>> pictures;
      std::vector<std::string> captions;
      for (const GraspTile& tile : by_planner->second.at(planner)) {
        pictures.push_back(tile.picture);
        captions.push_back(tile.caption);
      }
      page.Subheading(fmt::format("{}, {}", planner, condition));
      if (pictures.empty()) {
        page.Note("No grasp was executed.");
        continue;
      }
      const std::string file = fmt::format("gallery_grasps_{}_{}.png", condition, planner);
      const int columns = std::clamp(kGalleryWidth_px / pictures.front().width(), 1,
                                     static_cast<int>(pictures.size()));
      WritePng(folder / file, ContactSheet(pictures, captions, columns));
      page.WidePicture(file, fmt::format("grasps of planner {}", planner));
    }
  }
}

}  // namespace pickbed::eval
