#include "eval/benchmark/completed_grasps.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "eval/trial/trial.h"
#include "grasp/planners/table.h"
#include "scenes/base/error.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {
namespace {

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

// The scenario of a condition: a bin with one drawn shape and a single attempt, or the bins.
ScenarioSpec SpecOf(const std::string& condition, const ScenarioSpec& scenario,
                    const std::string& planner, const CompletedGraspsOptions& options) {
  ScenarioSpec spec = scenario;
  spec.seed = options.seed;
  SetPlanner(planner, options.completion, spec);
  if (condition == kGraspConditions[0]) {
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

TableCells GraspTable(const CompletedGrasps& grasps) {
  TableCells table{{"condition", "planner", "instances picked", "difference, points",
                    "grasps that succeed", "shapes"}};
  for (const char* condition : kGraspConditions) {
    for (const std::string& planner : grasps.planners) {
      const auto& shapes = grasps.shapes.at(condition).at(planner);
      const GraspRate picked = GraspRateOf(grasps, condition, planner, &ShapeGrasps::picked);
      const GraspRate reference =
          GraspRateOf(grasps, condition, grasps.planners.front(), &ShapeGrasps::picked);
      const bool is_reference = planner == grasps.planners.front();
      table.push_back(
          {condition, planner, RateText(picked.rate),
           is_reference ? "-"
                        : PointsText(picked.rate.rate() - reference.rate.rate(), picked.difference),
           RateText(GraspRateOf(grasps, condition, planner, &ShapeGrasps::grasps).rate),
           std::to_string(shapes.size())});
    }
  }
  return table;
}

}  // namespace

void AddTrial(const TrialResult& trial, const std::vector<std::string>& names,
              std::map<std::string, ShapeGrasps>& shapes) {
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
  }
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
    for (const std::string& planner : options.planners) grasps.shapes[condition][planner];
  }
  const int planners = static_cast<int>(options.planners.size());
  const int total = planners * (options.single + options.bins);
  int done = 0;
  for (const char* condition : kGraspConditions) {
    const bool is_single = condition == kGraspConditions[0];
    std::vector<std::unique_ptr<TrialRunner>> runners;
    for (const std::string& planner : options.planners) {
      runners.push_back(std::make_unique<TrialRunner>(
          SpecOf(condition, scenario.spec, planner, options), scenario.objects));
    }
    // All planners pick a bin before the next one, so an interrupted benchmark is paired.
    for (int bin = 0; bin < (is_single ? options.single : options.bins); ++bin) {
      if (on_progress && !on_progress(done, total)) return grasps;
      for (int i = 0; i < planners; ++i) {
        AddTrial(runners[i]->Run(BinIndex(bin)), names,
                 grasps.shapes[condition][options.planners[i]]);
      }
      done += planners;
    }
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

std::string CompletedGraspsText(const CompletedGrasps& grasps) {
  return AlignedText(GraspTable(grasps));
}

ResultColumns CompletedGraspsColumns() {
  return {{"condition", "single: one shape in the bin, one attempt; bins: several shapes"},
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
          {"succeeded", "number of these that succeeded"}};
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
      csv += fmt::format("{},{},{},{},{},{},{:.4f},{},{},{}\n", condition, planner,
                         grasps.shapes.at(condition).at(planner).size(), picked.rate.samples,
                         picked.rate.hits, IntervalCells(picked.rate.ci95, 4),
                         picked.rate.rate() - reference.rate(), IntervalCells(picked.difference, 4),
                         executed.samples, executed.hits);
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

void AddCompletedGrasps(const CompletedGrasps& grasps, HtmlPage& page) {
  page.Heading("Grasps of unknown objects");
  page.Paragraph(
      "Picks in physics. Single: one shape in the bin, and one attempt. Bins: several shapes, "
      "picked by the policy of the scenario. All planners get the same bins. Row truth plans on "
      "the "
      "true shapes. 95 % intervals are over shapes, and differences to the first planner are "
      "paired "
      "by shape.");
  page.Table(GraspTable(grasps));
}

}  // namespace pickbed::eval
