#include "eval/bop/score_accumulator.h"

#include <algorithm>
#include <array>

#include "eval/bop/scores.h"
#include "eval/metrics/pose_errors.h"
#include "eval/stats/statistics.h"
#include "eval/trial/pose_matching.h"
#include "eval/trial/stage_oracle.h"
#include "grasp/tolerance/tolerance_model.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {
namespace {

constexpr int kSteps = 10;
constexpr double kMspdWidth_px = 640;
constexpr double kAdiDiameters = 0.1;  // the usual threshold (Hinterstoisser et al. 2012)
constexpr double kStep_mm = 2;         // thresholds of MSSD in BOP25: 2, 4, ... 20 mm
constexpr int kCorrectStep = 1;        // index of 0.1 diameters in Steps()

// 0.05, 0.1, ... 0.5: tolerances and thresholds of VSD and MSSD. Times 100: thresholds of MSPD, px.
std::array<double, kSteps> Steps() {
  std::array<double, kSteps> steps;
  for (int i = 0; i < kSteps; ++i) steps[i] = 0.05 * (i + 1);
  return steps;
}

// Visible fractions from which instances count in DatasetScores::floors.
constexpr std::array kFloors{0.1, 0.3, 0.5, 0.7, 0.9};

// Counts of one floor.
struct FloorCount {
  int instances = 0;
  std::array<int, kSteps> found{};
};

// Number of found instances of one object at each threshold.
struct Found {
  int wanted = 0;
  std::array<int, kSteps * kSteps> vsd{};  // [tolerance][threshold]
  std::array<int, kSteps> mssd{}, mspd{};
  int adi = 0;
  double pick_chances = 0;  // sum of success probabilities over the instances

  void Add(const Found& other) {
    wanted += other.wanted;
    adi += other.adi;
    for (size_t i = 0; i < vsd.size(); ++i) vsd[i] += other.vsd[i];
    for (int i = 0; i < kSteps; ++i) mssd[i] += other.mssd[i];
    for (int i = 0; i < kSteps; ++i) mspd[i] += other.mspd[i];
  }
};

// Mean recall over the thresholds.
template <size_t n>
double AverageRecall(const std::array<int, n>& found, int wanted) {
  double sum = 0;
  for (const int count : found) sum += Recall{count, wanted}.value();
  return sum / n;
}

// Object models for error computation, made on first use.
class ObjectModels {
 public:
  explicit ObjectModels(ScoreAccumulator::ModelOf model_of)
      : model_of_(std::move(model_of)), renderer_({}, {0, 0}) {}

  struct Entry {
    MetricModel metric;
    int mesh = 0;
  };
  const Entry& Of(int object_id) {
    if (const auto known = models_.find(object_id); known != models_.end()) return known->second;
    const auto model = model_of_(object_id);
    Entry entry{MakeMetricModel(*model, 0), renderer_.AddMesh(model->mesh_O)};
    return models_.emplace(object_id, std::move(entry)).first->second;
  }

  // The BOP toolkit renders pixel i at i + 0.5, but computes its distance from the camera with i.
  // VSD follows it, because near a threshold the scores depend on it.
  DistanceCrop Draw(int object_id, const Pose& X_CO, const CameraIntrinsics& camera) {
    const RenderInstance instance{Of(object_id).mesh, X_CO, 1};
    const CameraIntrinsics rendered(camera.width(), camera.height(), camera.fx(), camera.fy(),
                                    camera.cx() - 0.5, camera.cy() - 0.5);
    const RenderedImage image = renderer_.RenderDepth({rendered, Pose::Identity()}, {&instance, 1});
    return DistanceCropOf(image.depth_m, camera);
  }

 private:
  ScoreAccumulator::ModelOf model_of_;
  Renderer renderer_;
  std::map<int, Entry> models_;
};

// Estimates and instances of one object in one image.
struct Group {
  int object_id = 0;
  std::vector<const DatasetEstimate*> estimates;
  std::vector<Pose> X_CO_true;
  std::vector<double> visible;

  ErrorTable Table() const {
    ErrorTable table{object_id, {}, visible, {}};
    for (const DatasetEstimate* estimate : estimates) table.scores.push_back(estimate->score);
    table.errors.assign(estimates.size(), std::vector<double>(X_CO_true.size()));
    return table;
  }
  // Fills the errors of every estimate against every instance.
  template <typename ErrorOf>
  ErrorTable Table(ErrorOf error_of) const {
    ErrorTable table = Table();
    for (size_t e = 0; e < estimates.size(); ++e) {
      for (size_t t = 0; t < X_CO_true.size(); ++t) {
        table.errors[e][t] = error_of(estimates[e]->X_CO, X_CO_true[t]);
      }
    }
    return table;
  }
};

}  // namespace

struct ScoreAccumulator::Impl {
  Impl(ModelOf model_of, const VsdOptions& options, ToleranceOf tolerance_of, int max_estimates)
      : models_(std::move(model_of)),
        options_(options),
        tolerance_of_(std::move(tolerance_of)),
        max_estimates_(max_estimates) {}

  void AddImage(const ScoredImage& truth, const ImageTargets& targets,
                const std::vector<const DatasetEstimate*>& estimates) {
    ++images_;
    std::map<int, Group> groups = GroupsOf(truth, estimates);
    if (targets.localised) {
      const Image<float> measured_m = DistancesOf(truth.depth_m, truth.intrinsics);
      for (const auto& [object_id, count] : targets.counts) {
        groups[object_id].object_id = object_id;
        Localise(groups[object_id], count, truth.intrinsics, measured_m);
      }
    }
    if (!targets.detected) return;
    for (const auto& [object_id, group] : groups) CountFound(MssdTable(group));
    if (estimates.size() > static_cast<size_t>(max_estimates_)) {
      std::vector<double> values;
      for (const DatasetEstimate* estimate : estimates) values.push_back(estimate->score);
      std::vector<const DatasetEstimate*> best;
      for (const int i : HighestScores(values, max_estimates_)) best.push_back(estimates[i]);
      groups = GroupsOf(truth, best);
    }
    for (const auto& [object_id, group] : groups) {
      if (group.X_CO_true.empty()) {
        absent_ += static_cast<int>(group.estimates.size());
        continue;
      }
      mssd_tables_.push_back(MssdTable(group));
      mssd_mm_tables_.push_back(InMillimetres(mssd_tables_.back()));
      mspd_tables_.push_back(MspdTable(group, truth.intrinsics));
    }
  }

  void Finish(DatasetScores& scores) const {
    scores.images = images_;
    scores.estimates_of_absent = absent_;
    Found all;
    for (const auto& [object_id, found] : found_) {
      all.Add(found);
      ObjectScores& object = scores.objects[object_id];
      object.wanted = found.wanted;
      object.ar_vsd = AverageRecall(found.vsd, found.wanted);
      object.ar_mssd = AverageRecall(found.mssd, found.wanted);
      object.ar_mspd = AverageRecall(found.mspd, found.wanted);
      object.adi_recall = Recall{found.adi, found.wanted}.value();
      if (ToleranceFor(object_id) != nullptr && found.wanted > 0) {
        object.pick_chance = found.pick_chances / found.wanted;
      }
    }
    scores.wanted = all.wanted;
    scores.ar_vsd = AverageRecall(all.vsd, all.wanted);
    scores.ar_mssd = AverageRecall(all.mssd, all.wanted);
    scores.ar_mspd = AverageRecall(all.mspd, all.wanted);
    scores.adi_recall = Recall{all.adi, all.wanted}.value();
    int detectable = 0;
    for (const double step : Steps()) {
      for (const auto& [object_id, ap] : AveragePrecisions(mssd_tables_, step)) {
        scores.objects[object_id].detectable = true;
        scores.objects[object_id].ap_mssd += ap / kSteps;
      }
      for (const auto& [object_id, ap] : AveragePrecisions(mspd_tables_, 100 * step)) {
        scores.objects[object_id].ap_mspd += ap / kSteps;
      }
    }
    for (int i = 1; i <= kSteps; ++i) {
      for (const auto& [object_id, ap] : AveragePrecisions(mssd_mm_tables_, kStep_mm * i)) {
        scores.objects[object_id].ap_mssd_mm += ap / kSteps;
      }
    }
    for (const auto& [object_id, reported] : reported_) {
      if (reported.wanted == 0) continue;  // only estimates
      ObjectScores& object = scores.objects[object_id];
      object.detect_wanted = reported.wanted;
      object.never_reported = reported.wanted - reported.found;
    }
    for (const auto& [object_id, object] : scores.objects) {
      detectable += object.detectable;
      scores.ap_mssd += object.ap_mssd;
      scores.ap_mspd += object.ap_mspd;
      scores.ap_mssd_mm += object.ap_mssd_mm;
      scores.detect_wanted += object.detect_wanted;
      scores.never_reported += object.never_reported;
    }
    scores.ap_mssd /= std::max(1, detectable);
    scores.ap_mspd /= std::max(1, detectable);
    scores.ap_mssd_mm /= std::max(1, detectable);
    for (size_t f = 0; f < kFloors.size(); ++f) {
      const FloorCount& count = floors_[f];
      scores.floors.push_back({kFloors[f], count.instances, count.found[kCorrectStep],
                               AverageRecall(count.found, count.instances)});
    }
  }

  ErrorTable InMillimetres(ErrorTable table) {
    const double diameter_mm = 1e3 * models_.Of(table.object_id).metric.diameter_m;
    for (std::vector<double>& of_estimate : table.errors) {
      for (double& error : of_estimate) error *= diameter_mm;
    }
    return table;
  }

  // Counts the found instances at each threshold by visible fraction, and the reported ones.
  void CountFound(const ErrorTable& mssd) {
    const std::vector<bool> all(mssd.visible.size(), true);
    const auto steps = Steps();
    for (size_t f = 0; f < kFloors.size(); ++f) {
      floors_[f].instances += static_cast<int>(std::ranges::count_if(
          mssd.visible, [&](double visible) { return visible >= kFloors[f]; }));
    }
    for (int i = 0; i < kSteps; ++i) {
      for (const int instance : MatchGreedily(mssd, all, steps[i])) {
        if (instance < 0) continue;
        for (size_t f = 0; f < kFloors.size(); ++f) {
          floors_[f].found[i] += mssd.visible[instance] >= kFloors[f];
        }
      }
    }
    Recall& reported = reported_[mssd.object_id];
    for (size_t t = 0; t < mssd.visible.size(); ++t) {
      if (mssd.visible[t] < kMinVisible) continue;
      ++reported.wanted;
      reported.found += std::ranges::any_of(
          mssd.errors, [&](const auto& of_estimate) { return of_estimate[t] < kMatchDiameters; });
    }
  }

  static std::map<int, Group> GroupsOf(const ScoredImage& truth,
                                       const std::vector<const DatasetEstimate*>& estimates) {
    std::map<int, Group> groups;
    for (const ScoredInstance& instance : truth.instances) {
      Group& group = groups[instance.object_id];
      group.X_CO_true.push_back(instance.X_CO);
      group.visible.push_back(instance.visible_fraction);
    }
    for (const DatasetEstimate* estimate : estimates) {
      groups[estimate->object_id].estimates.push_back(estimate);
    }
    for (auto& [object_id, group] : groups) group.object_id = object_id;
    return groups;
  }

  // Errors in diameters.
  ErrorTable MssdTable(const Group& group) {
    const MetricModel& model = models_.Of(group.object_id).metric;
    return group.Table([&](const Pose& X_est, const Pose& X_true) {
      // As in the BOP toolkit, whose shortcut decides thresholds in mm of very small objects.
      const double apart_m = (X_est.translation() - X_true.translation()).norm();
      if (apart_m >= model.diameter_m) return kInfinity;
      return Mssd(model, X_est, X_true) / model.diameter_m;
    });
  }

  // Errors in diameters. ADI is slow, so two cases that decide the threshold skip it. MSSD is an
  // upper bound: if it is below the threshold, the table holds MSSD. If the box centers are at
  // least one diameter apart, the table holds their distance.
  ErrorTable AdiTable(const Group& group, const ErrorTable& mssd) {
    const MetricModel& model = models_.Of(group.object_id).metric;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& v : model.vertices_O) box.extend(v);
    ErrorTable table = group.Table([&](const Pose& X_est, const Pose& X_true) {
      return (X_est * box.center() - X_true * box.center()).norm() / model.diameter_m;
    });
    for (size_t e = 0; e < group.estimates.size(); ++e) {
      for (size_t t = 0; t < group.X_CO_true.size(); ++t) {
        double& error = table.errors[e][t];
        if (mssd.errors[e][t] < kAdiDiameters) {
          error = mssd.errors[e][t];
        } else if (error < 1) {
          error = Adi(model, group.estimates[e]->X_CO, group.X_CO_true[t]) / model.diameter_m;
        }
      }
    }
    return table;
  }

  // Errors in px, scaled to an image 640 px wide.
  ErrorTable MspdTable(const Group& group, const CameraIntrinsics& camera) {
    const MetricModel& model = models_.Of(group.object_id).metric;
    return group.Table([&](const Pose& X_est, const Pose& X_true) {
      return Mspd(model, camera, X_est, X_true) * kMspdWidth_px / camera.width();
    });
  }

  // One table per VSD tolerance.
  std::vector<ErrorTable> VsdTables(const Group& group, const CameraIntrinsics& camera,
                                    const Image<float>& measured_m) {
    std::vector<ErrorTable> tables(kSteps, group.Table());
    const double diameter_m = models_.Of(group.object_id).metric.diameter_m;
    std::vector<DistanceCrop> truths;
    for (const Pose& X_CO : group.X_CO_true) {
      truths.push_back(models_.Draw(group.object_id, X_CO, camera));
    }
    for (size_t e = 0; e < group.estimates.size(); ++e) {
      const DistanceCrop estimated =
          models_.Draw(group.object_id, group.estimates[e]->X_CO, camera);
      for (size_t t = 0; t < truths.size(); ++t) {
        const std::vector<double> errors =
            Vsd(estimated, truths[t], measured_m, diameter_m, Steps(), options_);
        for (int i = 0; i < kSteps; ++i) tables[i].errors[e][t] = errors[i];
      }
    }
    return tables;
  }

  const ToleranceModel* ToleranceFor(int object_id) const {
    return tolerance_of_ ? tolerance_of_(object_id) : nullptr;
  }

  // Sum of the pick success probabilities over the estimates that are matched to an instance.
  double PickChances(const Group& group, const ErrorTable& mssd, int count) const {
    const ToleranceModel* tolerance = ToleranceFor(group.object_id);
    if (tolerance == nullptr) return 0;
    double sum = 0;
    const std::vector<int> taken =
        MatchGreedily(mssd, MostVisible(group.visible, count), kMatchDiameters);
    for (size_t e = 0; e < taken.size(); ++e) {
      if (taken[e] < 0) continue;
      sum += SuccessProbability(*tolerance,
                                group.X_CO_true[taken[e]].inverse() * group.estimates[e]->X_CO);
    }
    return sum;
  }

  void Localise(Group group, int count, const CameraIntrinsics& camera,
                const Image<float>& measured_m) {
    const std::vector<int> kept = HighestScores(group.Table().scores, count);
    std::vector<const DatasetEstimate*> best;
    for (const int i : kept) best.push_back(group.estimates[i]);
    group.estimates = std::move(best);
    Found& found = found_[group.object_id];
    const ErrorTable mssd = MssdTable(group), mspd = MspdTable(group, camera);
    const std::vector<ErrorTable> vsd = VsdTables(group, camera, measured_m);
    const auto steps = Steps();
    found.adi += RecallOf(AdiTable(group, mssd), count, kAdiDiameters).found;
    found.wanted += RecallOf(mssd, count, steps[0]).wanted;
    found.pick_chances += PickChances(group, mssd, count);
    for (int i = 0; i < kSteps; ++i) {
      found.mssd[i] += RecallOf(mssd, count, steps[i]).found;
      found.mspd[i] += RecallOf(mspd, count, 100 * steps[i]).found;
      for (int tau = 0; tau < kSteps; ++tau) {
        found.vsd[tau * kSteps + i] += RecallOf(vsd[tau], count, steps[i]).found;
      }
    }
  }

  ObjectModels models_;
  VsdOptions options_;
  ToleranceOf tolerance_of_;
  int max_estimates_;
  int images_ = 0;
  int absent_ = 0;  // estimates of objects that their image does not have
  std::map<int, Found> found_;
  std::vector<ErrorTable> mssd_tables_, mssd_mm_tables_, mspd_tables_;
  std::map<int, Recall> reported_;
  std::array<FloorCount, kFloors.size()> floors_{};
};

ScoreAccumulator::ScoreAccumulator(ModelOf model_of, const VsdOptions& options,
                                   ToleranceOf tolerance_of, int max_estimates)
    : impl_(std::make_unique<Impl>(std::move(model_of), options, std::move(tolerance_of),
                                   max_estimates)) {}

ScoreAccumulator::~ScoreAccumulator() = default;

void ScoreAccumulator::AddImage(const ScoredImage& truth, const ImageTargets& targets,
                                const std::vector<const DatasetEstimate*>& estimates) {
  impl_->AddImage(truth, targets, estimates);
}

void ScoreAccumulator::Finish(DatasetScores& scores) const { impl_->Finish(scores); }

}  // namespace pickbed::eval
