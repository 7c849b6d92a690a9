#pragma once

// The stages of a trial, which eval/trial.cpp strings together to picks until the bin is empty and
// eval/occlusion_trial.cpp to one look and pick for each band of the target's visible fraction.

#include <memory>
#include <optional>
#include <vector>

#include "eval/estimator_runner.h"
#include "eval/metrics.h"
#include "eval/trial.h"
#include "eval/virtual_cell.h"

namespace pickbed {

// A grasp that failed, in the world.
struct FailedGrasp {
  int object = 0;
  Eigen::Vector3d position_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d approach_W = Eigen::Vector3d::UnitZ();
  bool picked_since = false;  // another part was taken out, which may have cleared the way
};

struct TrialRunner::Impl {
  // A trial under way.
  struct Live {
    TrialResult result;
    Scene scene;
    std::vector<FailedGrasp> failed;
    TrialObserver* observer = nullptr;
  };

  Impl(const ScenarioSpec& spec, const ObjectSet& objects, const Progress& on_progress,
       const TrialOptions& options);

  Live Drop(int scene);
  View See(Live& live, int look);
  std::vector<PoseHypothesis> Believe(const View& view, Live& live, PickRecord& record);
  // With truth in place of the stages that are fed.
  std::vector<PoseHypothesis> Fed(std::vector<PoseHypothesis> believed, const View& view,
                                  const Scene& scene) const;
  // One look: fills the record's instances and hypotheses.
  std::vector<PoseHypothesis> Estimate(const View& view, Live& live, PickRecord& record);
  // Hypotheses that may be grasped: those that stand on the record's target where it has one.
  std::vector<int> AimsOf(const PickRecord& record) const;
  // Best first, without those that would only repeat a failure.
  std::vector<Grasp> Plan(const View& view, const std::vector<BelievedPose>& poses, Live& live,
                          PickRecord& record);
  // The same where truth will tell what is free: neither what was seen nor what is believed of
  // other parts stands in the way, and no approach is too flat and no candidate too poor.
  std::vector<Grasp> PlanBoldly(const std::vector<BelievedPose>& poses, const Live& live,
                                const PickRecord& record) const;
  PlanOptions Ranking(const Live& live, const PickRecord& record) const;  // as the policy says
  // Without those that failed; where nothing else is left, with those of them that failed before
  // another part was picked.
  std::vector<Grasp> WithoutRetries(std::vector<Grasp> grasps,
                                    const std::vector<BelievedPose>& poses,
                                    const std::vector<FailedGrasp>& failed) const;
  std::optional<Grasp> FirstThatSucceeds(const std::vector<Grasp>& grasps,
                                         const std::vector<BelievedPose>& poses, const Live& live,
                                         const PickRecord& record) const;
  std::optional<Grasp> Choose(const std::vector<BelievedPose>& poses,
                              const std::vector<Grasp>& planned, Live& live,
                              const PickRecord& record) const;
  ExecuteResult Try(const Scene& scene, const Grasp& grasp, const BelievedPose& pose,
                    const PickRecord& record) const;
  void Execute(const PoseHypothesis& hypothesis, const BelievedPose& pose, Live& live,
               PickRecord& record);
  void PickOnce(Live& live, int target = -1, int band = -1);
  void PickAll(Live& live);  // until the bin is empty or the policy ends it
  TrialResult RunSeries(int scene, TrialObserver* observer);

  ScenarioSpec spec;
  Progress on_progress;
  TrialOptions options;
  VirtualCell cell;
  GripperSpec gripper;
  ExecuteOptions execute;
  std::vector<MetricModel> metric_models;
  std::vector<std::vector<GraspCandidate>> candidates;
  std::unique_ptr<EstimatorRunner> estimator;  // null: all it would tell is fed
  std::unique_ptr<FedRefiner> fed_refiner;     // null: nothing that is fed is refined
};

}  // namespace pickbed
