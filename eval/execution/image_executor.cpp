#include "eval/execution/image_executor.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "eval/bop/layout.h"
#include "eval/bop/vsd.h"
#include "eval/cell/cell_errors.h"
#include "eval/metrics/pose_errors.h"
#include "eval/trial/failure_attribution.h"
#include "eval/trial/grasp_choice.h"
#include "eval/trial/oracle_estimator.h"
#include "eval/trial/pose_matching.h"
#include "grasp/plan/lift_clearance.h"
#include "scenes/base/error.h"
#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

constexpr double kSamePlaceDiameters = 0.25;
constexpr int kVsdSteps = 10;  // tolerances 0.05, 0.1, ... 0.5 diameters

// Computes the BOP errors of poses with the meshes of the data set.
class ErrorMeasure {
 public:
  explicit ErrorMeasure(const fs::path& root)
      : folder_(EvalModelsFolder(root)),
        infos_(ReadModelsInfo(folder_, ThrowFault)),
        renderer_({}, {0, 0}) {}

  BopErrors Of(int object_id, const Pose& X_est, const Pose& X_true, const CameraIntrinsics& camera,
               const Image<float>& measured_m) {
    const Entry& entry = EntryOf(object_id);
    std::vector<double> taus;
    for (int i = 1; i <= kVsdSteps; ++i) taus.push_back(0.05 * i);
    double vsd = 0;
    for (const double error : Vsd(Draw(entry, X_est, camera), Draw(entry, X_true, camera),
                                  measured_m, entry.metric.diameter_m, taus)) {
      vsd += error / kVsdSteps;
    }
    return {vsd, Mssd(entry.metric, X_est, X_true), Mspd(entry.metric, camera, X_est, X_true),
            Add(entry.metric, X_est, X_true), Adi(entry.metric, X_est, X_true)};
  }

 private:
  struct Entry {
    MetricModel metric;
    int mesh = 0;
  };
  const Entry& EntryOf(int object_id) {
    if (const auto known = entries_.find(object_id); known != entries_.end()) return known->second;
    const auto model =
        LoadDatasetModel(folder_, object_id, infos_.at(object_id), ModelName(object_id));
    Entry entry{MakeMetricModel(*model, 0), renderer_.AddMesh(model->mesh_O)};
    return entries_.emplace(object_id, std::move(entry)).first->second;
  }
  DistanceCrop Draw(const Entry& entry, const Pose& X_CO, const CameraIntrinsics& camera) {
    const RenderInstance instance{entry.mesh, X_CO, 1};
    return DistanceCropOf(renderer_.RenderDepth({camera, Pose::Identity()}, {&instance, 1}).depth_m,
                          camera);
  }

  fs::path folder_;
  std::map<int, DatasetModelInfo> infos_;
  Renderer renderer_;
  std::map<int, Entry> entries_;
};

BopErrors InfiniteErrors() {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  return {1, kInf, kInf, kInf, kInf};
}

TrialOptions OptionsWith(const fs::path& log_dir,
                         const std::function<void(const std::string&)>& on_warning) {
  TrialOptions options;
  options.log_dir = log_dir;
  options.on_warning = on_warning;
  return options;
}

std::vector<PoseHypothesis> HypothesesOf(const std::vector<MethodPose>& poses) {
  std::vector<PoseHypothesis> hypotheses;
  for (const MethodPose& pose : poses) {
    PoseHypothesis& hypothesis = hypotheses.emplace_back();
    hypothesis.object = ObjectId(pose.object_id - 1);
    hypothesis.X_CO = pose.X_CO;
    hypothesis.score = pose.confidence;
  }
  return hypotheses;
}

}  // namespace

ScenarioSpec WithoutEstimator(ScenarioSpec spec) {
  spec.estimator = {};
  spec.estimator.name = kOracleName;  // needs no file
  spec.occlusion.enabled = false;
  return spec;
}

int RequestedPicks(const ImageTruth& image, const std::vector<bool>& is_wanted, int picks) {
  int visible = 0;
  for (size_t i = 0; i < image.instances.size(); ++i) {
    visible += is_wanted.at(image.instances[i].object_id - 1) &&
               image.infos.at(i).visib_fract >= kCountedVisibility;
  }
  return std::min(visible, picks);
}

struct ImageExecutor::Impl {
  Impl(const ScenarioSpec& spec, const ObjectSet& objects, const fs::path& root,
       const ExecutedScenes& all_scenes, int max_picks, const fs::path& log_dir,
       const std::function<void(const std::string&)>& on_warning)
      : setup(WithoutEstimator(spec), objects, {}, OptionsWith(log_dir, on_warning)),
        scenes(all_scenes),
        picks(max_picks),
        measure(root) {
    CheckInput(setup.has_poses,
               fmt::format("{}: planner {} works without poses, so it cannot execute results; "
                           "choose another planner",
                           spec.At("planner.name"), spec.planner.name));
    for (size_t i = 0; i < objects.size(); ++i)
      is_wanted.push_back(setup.cell.IsWanted(ObjectId(i)));
  }

  // An image of the data set, ready for the planner.
  struct Shown {
    const ExecutedScene& scene;
    const ImageTruth& image;
    const Scene& physics;
    ObjectSet objects;  // in their true sizes
    RgbdFrame frame;
    Camera camera;
    Pose X_WB;                // of the bin, as the cell assumes it
    Image<float> measured_m;  // distances from the camera center
    InstanceMatcher truth;
  };

  Shown Show(int scene_id, int image_id) const {
    const ExecutedScene& scene = scenes.at(scene_id);
    const ImageTruth& image = scene.truth.images.at(image_id);
    const Scene& physics = scene.stored.Of(image_id, scene.truth.folder);
    RgbdFrame frame = ReadFrame(scene.truth, image);
    const Camera camera(frame.intrinsics, image.X_CW->inverse());
    const CellCalibration calibration =
        CalibrationOf(setup.cell.camera(), setup.cell.ErrorsOf(scene.stored.bin_index));
    std::vector<TrueInstance> instances;
    for (size_t i = 0; i < image.instances.size(); ++i) {
      const ObjectId object(image.instances[i].object_id - 1);
      instances.push_back({object, image.instances[i].X_CO,
                           is_wanted[object] ? image.infos[i].visib_fract : 0,
                           physics.objects[i].instance});
    }
    Image<float> measured_m = DistancesOf(frame.depth_m, frame.intrinsics);
    return {scene,
            image,
            physics,
            ObjectsOfSizes(setup.cell.objects(), scene.stored.sizes),
            std::move(frame),
            camera,
            calibration.X_WB.value_or(Pose::Identity()),
            std::move(measured_m),
            InstanceMatcher(setup.metric_models, std::move(instances))};
  }

  // Indices of the poses that are not at a place that was picked.
  std::vector<int> Unpicked(const std::vector<EstimatedPose>& poses,
                            const std::vector<int>& picked) const {
    const auto center_W = [&](int i) {
      return Eigen::Vector3d(poses[i].X_WO * setup.cell.objects()[poses[i].object]->mass.com_O);
    };
    std::vector<int> unpicked;
    for (int i = 0; i < static_cast<int>(poses.size()); ++i) {
      const double near_m = kSamePlaceDiameters * setup.cell.objects()[poses[i].object]->diameter_m;
      const bool is_picked = std::ranges::any_of(
          picked, [&](int other) { return (center_W(i) - center_W(other)).norm() < near_m; });
      if (!is_picked) unpicked.push_back(i);
    }
    return unpicked;
  }

  // By pose: whether its object would meet a wall while it is lifted.
  std::vector<bool> BlockedLifts(const Shown& shown,
                                 const std::vector<EstimatedPose>& poses) const {
    const PolicySpec& policy = setup.spec.policy;
    const Pose X_BW = shown.X_WB.inverse();
    std::vector<bool> blocked(poses.size(), false);
    for (size_t i = 0; i < poses.size() && policy.check_lift; ++i) {
      blocked[i] = grasp::LiftMeetsWall(setup.cell.bin(), *setup.cell.objects()[poses[i].object],
                                        X_BW * poses[i].X_WO, 1e-3 * policy.lift_clearance_mm);
    }
    return blocked;
  }

  // Plans on the targets and executes the best grasp. Fills `record`.
  void Pick(const Shown& shown, const std::vector<EstimatedPose>& poses,
            const std::vector<int>& targets, AttemptRecord& record) {
    if (targets.empty()) return;
    const uint64_t seed =
        Rng::Derive(setup.spec.seed, shown.scene.stored.bin_index,
                    fmt::format("execute/{}/{}", shown.image.image_id, record.attempt))
            .Next();
    PlanResult plan = setup.planner->Plan({shown.frame, shown.camera.X_WC(),
                                           BinPlacement{setup.cell.bin(), shown.X_WB}, poses,
                                           targets, PlanOptions().max_grasps, seed});
    if (plan.failure && setup.options.on_warning) {
      setup.options.on_warning(fmt::format("scene {} image {}: {}", shown.scene.truth.scene_id,
                                           shown.image.image_id, plan.failure->text));
    }
    record.planner_failure = std::move(plan.failure);
    if (plan.grasps.empty()) return;
    record.grasp = plan.grasps.front();
    record.chosen = record.grasp->hypothesis;
    record.matched_instance =
        MatchedInstance(record.hypotheses.at(record.chosen), setup.options.match_diameters);
    record.outcome = TryGrasp(setup, {shown.physics, shown.objects}, *record.grasp,
                              record.hypotheses, record.errors)
                         .outcome;
  }

  // `unpicked`: the poses that the pick could use. One whose lift is blocked is a pose without a
  // grasp, as in a run.
  FailureReason FailureOf(const Shown& shown, const AttemptRecord& record,
                          const std::vector<ScoredHypothesis>& hypotheses,
                          const std::vector<int>& unpicked) const {
    const double match = setup.options.match_diameters;
    if (record.grasp) return AttributeFailure(record, hypotheses, match, shown.truth);
    if (record.planner_failure) return record.planner_failure->reason;
    std::vector<ScoredHypothesis> left;
    for (const int i : unpicked) left.push_back(hypotheses[i]);
    return AttributeFailure(record, left, match, shown.truth);
  }

  ExecutedPick RowOf(const Shown& shown, const std::string& method, const AttemptRecord& record,
                     const std::vector<MethodPose>& poses, FailureReason failure) {
    ExecutedPick row;
    row.method = method;
    row.scene_id = shown.scene.truth.scene_id;
    row.image_id = shown.image.image_id;
    row.pick = record.attempt;
    row.failure = failure;
    row.success = record.grasp.has_value() && failure == FailureReason::kNone;
    if (!record.grasp) return row;
    const MethodPose& pose = poses[record.chosen];
    row.object_id = pose.object_id;
    row.score = pose.score;
    row.instance = record.matched_instance;
    const InstanceMatch nearest = shown.truth.Nearest(ObjectId(pose.object_id - 1), pose.X_CO);
    row.errors = InfiniteErrors();
    if (nearest.position < 0) return row;
    const TrueInstance& instance = shown.truth.instances()[nearest.position];
    if (row.instance >= 0) row.visible_fraction = instance.visible_fraction;
    row.errors = measure.Of(pose.object_id, pose.X_CO, instance.X_CO, shown.frame.intrinsics,
                            shown.measured_m);
    return row;
  }

  // Executes the picks of one method.
  void Execute(const Shown& shown, const Method& method, std::vector<ExecutedPick>& rows) {
    static const std::vector<MethodPose> kNone;
    const auto found = method.images.find({shown.scene.truth.scene_id, shown.image.image_id});
    const std::vector<MethodPose>& poses = found == method.images.end() ? kNone : found->second;
    const AttemptScore score = ScoreAgainstTruth(shown.truth, shown.camera, HypothesesOf(poses));
    AttemptRecord record;
    record.instances = score.instances;
    record.hypotheses = score.Records();
    std::vector<EstimatedPose> estimated;
    for (const HypothesisRecord& hypothesis : record.hypotheses) {
      estimated.push_back(PoseOf(hypothesis));
    }
    const std::vector<bool> blocked = BlockedLifts(shown, estimated);
    std::vector<int> picked;
    const int requested = RequestedPicks(shown.image, is_wanted, picks);
    for (int pick = 0; pick < requested; ++pick) {
      AttemptRecord own = record;
      own.attempt = pick;
      own.errors = setup.cell.ErrorsOf(shown.scene.stored.bin_index, pick);
      const std::vector<int> unpicked = Unpicked(estimated, picked);
      std::vector<int> targets = unpicked;
      std::erase_if(targets, [&](int i) { return blocked[i]; });
      Pick(shown, estimated, targets, own);
      const FailureReason failure = FailureOf(shown, own, score.hypotheses, unpicked);
      rows.push_back(RowOf(shown, method.name, own, poses, failure));
      if (own.grasp) picked.push_back(own.chosen);
    }
  }

  TrialSetup setup;
  const ExecutedScenes& scenes;
  int picks;
  ErrorMeasure measure;
  std::vector<bool> is_wanted;  // by object
};

ImageExecutor::ImageExecutor(const ScenarioSpec& spec, const ObjectSet& objects,
                             const fs::path& root, const ExecutedScenes& scenes, int picks,
                             const fs::path& log_dir,
                             const std::function<void(const std::string&)>& on_warning)
    : impl_(std::make_unique<Impl>(spec, objects, root, scenes, picks, log_dir, on_warning)) {}

ImageExecutor::~ImageExecutor() = default;

std::vector<ExecutedPick> ImageExecutor::Execute(int scene_id, int image_id,
                                                 const std::vector<Method>& methods) {
  const Impl::Shown shown = impl_->Show(scene_id, image_id);
  std::vector<ExecutedPick> rows;
  for (const Method& method : methods) impl_->Execute(shown, method, rows);
  return rows;
}

}  // namespace pickbed::eval
