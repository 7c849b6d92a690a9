#include "eval/tolerance/statistics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "eval/metrics/metric_table.h"

namespace pickbed::eval {
namespace {

double UnitsOf(const ToleranceOptions& options, int axis, int level) {
  return level * (ErrorAxisTable()[axis].coordinate < 3 ? options.step_mm : options.step_deg);
}

// Finds where the share falls below `minimum`, from the center to one side.
void Reach(const std::vector<LevelShare>& levels, int center, int direction, double minimum,
           double& end, bool& open) {
  int at = center;
  const int last = direction < 0 ? 0 : static_cast<int>(levels.size()) - 1;
  while (at != last && levels[at + direction].share() >= minimum) at += direction;
  open = at == last;
  end = levels[at].offset;
  if (open) return;
  const double inside = levels[at].share(), outside = levels[at + direction].share();
  end += (inside - minimum) / (inside - outside) * (levels[at + direction].offset - end);
}

// For each grasp, the index of the first identical grasp.
std::vector<int> FirstAlike(const std::vector<TableGrasp>& grasps) {
  std::vector<int> first(grasps.size());
  for (size_t i = 0; i < grasps.size(); ++i) {
    const auto same = [&](const TableGrasp& other) {
      return other.place == grasps[i].place &&
             other.candidate.X_OG.matrix() == grasps[i].candidate.X_OG.matrix();
    };
    first[i] = static_cast<int>(std::find_if(grasps.begin(), grasps.end(), same) - grasps.begin());
  }
  return first;
}

class Reader {
 public:
  Reader(const ToleranceStudy& study, const std::vector<SampleOutcome>& outcomes)
      : study_(study),
        outcomes_(outcomes),
        options_(study.options),
        first_alike_(FirstAlike(study.grasps)) {}

  LevelShare AtTruth() const {
    LevelShare share;
    for (size_t i = 0; i < study_.samples.size(); ++i) {
      const PlannedSample& sample = study_.samples[i];
      if (sample.kind == SampleKind::kAxis && sample.level[0] == 0) Count(i, share);
    }
    return share;
  }

  AxisCurve Curve(int axis, const LevelShare& at_truth) const {
    AxisCurve curve{axis,
                    AxisHelp(ErrorAxisTable()[axis], *study_.table.gripper),
                    std::vector<LevelShare>(2 * options_.steps + 1),
                    {}};
    for (int level = -options_.steps; level <= options_.steps; ++level) {
      curve.levels[level + options_.steps].offset = UnitsOf(options_, axis, level);
    }
    curve.levels[options_.steps] = at_truth;
    for (size_t i = 0; i < study_.samples.size(); ++i) {
      const PlannedSample& sample = study_.samples[i];
      if (sample.kind != SampleKind::kAxis || sample.axis[0] != axis || sample.level[0] == 0)
        continue;
      Count(i, curve.levels[sample.level[0] + options_.steps]);
    }
    curve.region = RegionOf(curve.levels, options_.keep_share * at_truth.share());
    return curve;
  }

  PairMap Map(const std::array<int, 2>& pair) const {
    const int side = options_.steps / options_.pair_stride;
    PairMap map;
    map.axis = pair;
    for (int level = -side; level <= side; ++level) {
      map.offsets_a.push_back(UnitsOf(options_, pair[0], level * options_.pair_stride));
      map.offsets_b.push_back(UnitsOf(options_, pair[1], level * options_.pair_stride));
    }
    map.cells.resize(map.offsets_a.size() * map.offsets_b.size());
    for (size_t i = 0; i < study_.samples.size(); ++i) {
      const PlannedSample& sample = study_.samples[i];
      if (sample.kind != SampleKind::kPair || sample.axis != pair) continue;
      const int a = sample.level[0] / options_.pair_stride + side;
      const int b = sample.level[1] / options_.pair_stride + side;
      Count(i, map.cells[b * map.offsets_a.size() + a]);
    }
    return map;
  }

  ToleranceModel Fitted() const {
    ToleranceModel model = study_.model;
    std::vector<ToleranceSample> samples;
    for (size_t i = 0; i < study_.samples.size(); ++i) {
      const SampleKind kind = study_.samples[i].kind;
      if (kind == SampleKind::kTest || kind == SampleKind::kPair)
        continue;  // used only for the maps of pairs and the test
      samples.push_back(
          {ErrorInG(study_, study_.samples[i]), outcomes_[i].success, study_.samples[i].grasp});
    }
    FitTolerance(samples, options_.fit, model);
    return model;
  }

  // Samples with the same grasp form one cluster.
  std::vector<JudgedPick> TestPicks() const {
    std::vector<JudgedPick> picks;
    for (size_t i = 0; i < study_.samples.size(); ++i) {
      if (study_.samples[i].kind != SampleKind::kTest) continue;
      const PlannedSample& sample = study_.samples[i];
      picks.push_back({sample.X_OE, outcomes_[i].success, first_alike_[sample.grasp],
                       study_.grasps[sample.grasp].candidate.X_OG});
    }
    return picks;
  }

 private:
  void Count(size_t i, LevelShare& share) const {
    const bool success = outcomes_[i].success;
    ++share.samples;
    share.successes += success;
    Cluster& grasp = share.of_grasp[first_alike_[study_.samples[i].grasp]];
    ++grasp.samples;
    grasp.hits += success;
  }

  const ToleranceStudy& study_;
  const std::vector<SampleOutcome>& outcomes_;
  const ToleranceOptions& options_;
  const std::vector<int> first_alike_;
};

// Scores of all picks in order, larger if success is expected.
struct ScoreColumn {
  std::string name, help;
  std::vector<ScoredOutcome> scores;
};

// Scores by one metric over the picks of all objects.
ScoreColumn MetricColumn(const MetricRow& row, const std::vector<JudgedObject>& objects,
                         const std::vector<MetricModel>& metric_models) {
  const CameraIntrinsics no_camera;
  const Pose X_true = Pose::Identity();
  ScoreColumn column{row.name, row.help, {}};
  for (size_t i = 0; i < objects.size(); ++i) {
    for (const JudgedPick& pick : objects[i].picks) {
      const double error =
          row.compute({metric_models[i], no_camera, pick.X_OE, X_true, &objects[i].model});
      column.scores.push_back({-error, pick.success});
    }
  }
  return column;
}

// nullopt if the grasp of some pick is unknown.
std::optional<ScoreColumn> GraspColumn(const std::vector<JudgedObject>& objects) {
  ScoreColumn column{
      kGraspRisk, "predicted probability that the pick fails with the executed grasp", {}};
  for (const JudgedObject& object : objects) {
    for (const JudgedPick& pick : object.picks) {
      if (!pick.X_OG) return std::nullopt;
      column.scores.push_back(
          {SuccessProbability(object.model, pick.X_OE, *pick.X_OG), pick.success});
    }
  }
  return column;
}

std::vector<ScoreColumn> ScoreColumns(const std::vector<JudgedObject>& objects) {
  std::vector<MetricModel> metric_models;
  for (const JudgedObject& object : objects)
    metric_models.push_back(MakeMetricModel(object.object));
  std::vector<ScoreColumn> columns;
  for (const MetricRow& row : MetricsIn(kPredictor)) {
    columns.push_back(MetricColumn(row, objects, metric_models));
  }
  if (auto column = GraspColumn(objects)) columns.push_back(std::move(*column));
  // The score of the tolerance model is first; the others are compared with it.
  std::stable_partition(columns.begin(), columns.end(),
                        [](const ScoreColumn& c) { return c.name == kPickRiskMetric; });
  return columns;
}

OutcomeClusters InClusters(const ScoreColumn& column, const std::vector<int>& clusters_of) {
  std::map<int, std::vector<ScoredOutcome>> by_cluster;
  for (size_t i = 0; i < clusters_of.size(); ++i) {
    by_cluster[clusters_of[i]].push_back(column.scores[i]);
  }
  OutcomeClusters clusters;
  for (auto& [cluster, outcomes] : by_cluster) clusters.push_back(std::move(outcomes));
  return clusters;
}

}  // namespace

Interval LevelShare::band() const {
  std::vector<Cluster> grasps;
  for (const auto& [first, grasp] : of_grasp) grasps.push_back(grasp);
  return ClusterInterval(grasps);
}

std::string BandText(const LevelShare& level) {
  const Interval band = level.band();
  return band.is_known() ? IntervalText(band) : "(too few grasps)";
}

ToleranceRegion RegionOf(const std::vector<LevelShare>& levels, double minimum) {
  ToleranceRegion region;
  const int center = static_cast<int>(levels.size()) / 2;
  if (levels[center].successes == 0 || levels[center].share() < minimum) return region;
  Reach(levels, center, -1, minimum, region.low, region.low_open);
  Reach(levels, center, 1, minimum, region.high, region.high_open);
  return region;
}

ToleranceStatistics StatisticsOf(const ToleranceStudy& study,
                                 const std::vector<SampleOutcome>& outcomes) {
  const Reader reader(study, outcomes);
  const ObjectModel& object = *study.table.objects[0];
  ToleranceStatistics statistics;
  statistics.object = object.name;
  statistics.gripper = study.table.gripper->name;
  statistics.at_truth = reader.AtTruth();
  for (size_t axis = 0; axis < ErrorAxisTable().size(); ++axis) {
    statistics.axes.push_back(reader.Curve(static_cast<int>(axis), statistics.at_truth));
  }
  for (const auto& pair : study.options.pairs) statistics.pairs.push_back(reader.Map(pair));
  statistics.model = reader.Fitted();
  const std::vector<JudgedPick> picks = reader.TestPicks();
  statistics.test_picks = static_cast<int>(picks.size());
  statistics.predictors = JudgePredictors({{statistics.model, object, picks}});
  for (const JudgedPick& pick : picks) {
    const double p = SuccessProbability(statistics.model, pick.X_OE);
    statistics.brier += (p - pick.success) * (p - pick.success) / double(picks.size());
  }
  return statistics;
}

std::vector<Predictor> JudgePredictors(const std::vector<JudgedObject>& objects) {
  std::vector<int> clusters_of;  // by pick
  for (const JudgedObject& object : objects) {
    for (const JudgedPick& pick : object.picks) clusters_of.push_back(pick.cluster);
  }
  const std::set<int> seen(clusters_of.begin(), clusters_of.end());
  const bool clustered = seen.size() < clusters_of.size();
  const std::vector<ScoreColumn> columns = ScoreColumns(objects);
  const OutcomeClusters of_first = InClusters(columns.front(), clusters_of);
  std::vector<Predictor> predictors;
  for (const ScoreColumn& column : columns) {
    Predictor predictor{column.name, column.help, Auc(column.scores), {}};
    predictor.to_first = CompareAuc(column.scores, columns.front().scores);
    if (clustered) {
      const OutcomeClusters clusters = InClusters(column, clusters_of);
      predictor.auc.interval = ClusterBootstrapAuc(clusters);
      predictor.to_first.interval = ClusterBootstrapAucDifference(clusters, of_first);
    }
    predictors.push_back(std::move(predictor));
  }
  std::stable_sort(predictors.begin() + 1, predictors.end(),
                   [](const Predictor& a, const Predictor& b) { return a.auc.auc > b.auc.auc; });
  return predictors;
}

}  // namespace pickbed::eval
