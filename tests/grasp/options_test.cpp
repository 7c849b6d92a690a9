#include <gtest/gtest.h>

#include <vector>

#include "grasp/candidates/antipodal.h"
#include "grasp/candidates/candidates.h"
#include "grasp/candidates/suction.h"
#include "grasp/execute/attempt_world.h"
#include "grasp/execute/execute.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/place/placement.h"
#include "grasp/plan/plan.h"
#include "grasp/tolerance/tolerance_model.h"
#include "grasp/tolerance/tolerance_trial.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/planted_option.h"

namespace pickbed::tests {
namespace {

// Returns options with one value replaced.
template <typename Options, typename Value>
Options With(Value Options::*member, Value value) {
  Options options;
  options.*member = value;
  return options;
}

TEST(GraspOptions, ValuesOutOfRangeAreRefused) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.1, 0.5)};
  const ObjectModel& box = *objects[0];
  const ParallelJaw jaw = SmallJaw();
  const SuctionCup cup;
  const Scene scene = BoxesOnFloor({{0, 0}}, 0.03);
  const std::vector<std::vector<GraspCandidate>> candidates(1);
  const PlanInput input{scene.bin, {}, candidates, {}, objects, jaw};
  Rng rng(0);
  const auto plan = [&](const PlanOptions& options) { PlanGrasps(input, options); };
  const auto execute = [&](const ExecuteOptions& options) {
    ExecuteGrasp(scene, objects, {}, jaw, InstanceId{10}, options);
  };
  const auto make = [&](const GraspCandidateOptions& options) {
    MakeCandidates(box, jaw, rng, options);
  };
  const auto set_down = [&](const PlaceOptions& options) { SetDownWorths(box, {}, {}, options); };
  const auto table = [&](const TableOptions& options) {
    MakeTable(objects[0], nullptr, std::vector<GraspCandidate>(1), options);
  };
  const auto fit = [&](const ToleranceFitOptions& options) {
    ToleranceModel model;
    FitTolerance({}, options, model);
  };
  const PlantedOption planted[] = {
      {"max_tilt_rad", [&] { plan(With(&PlanOptions::max_tilt_rad, kNotANumber)); }},
      {"ranking", [&] { plan(With(&PlanOptions::ranking, std::string("worst"))); }},
      {"relaxed.min_quality",
       [&] {
         PlanOptions options;
         options.relaxed.min_quality = 2;
         plan(options);
       }},
      {"lift_m", [&] { execute(With(&ExecuteOptions::lift_m, -1.0)); }},
      {"world.near_m",
       [&] {
         ExecuteOptions options;
         options.world.near_m = kNotANumber;
         execute(options);
       }},
      {"rules.loose_opening",
       [&] {
         ExecuteOptions options;
         options.rules.loose_opening = -1;
         execute(options);
       }},
      {"near_m",
       [&] {
         AttemptWorld(scene, objects, Pose::Identity(), {}, {0, 0}, kNoInstance,
                      With(&AttemptWorldOptions::near_m, kNotANumber), {});
       }},
      {"loose_opening",
       [&] {
         const GraspOutcome outcome;
         JudgeByAllRules(outcome, With(&RuleOptions::loose_opening, kNotANumber));
       }},
      {"antipodal.candidates",
       [&] {
         GraspCandidateOptions options;
         options.antipodal.candidates = -5;
         make(options);
       }},
      {"robust.samples",
       [&] {
         GraspCandidateOptions options;
         options.robust.samples = -1;
         CachedCandidates(box, jaw, options);
       }},
      {"clearance_m",
       [&] {
         ParallelJaw broken = SmallJaw();
         broken.clearance_m = kNotANumber;
         MakeCandidates(box, broken, rng);
       }},
      {"cone_share",
       [&] {
         AntipodalGrasps(box, jaw.hand, 0, rng, With(&AntipodalOptions::cone_share, kNotANumber));
       }},
      {"max_tilt_rad",
       [&] {
         SuctionGrasps(box, cup.cup, rng, With(&SuctionOptions::max_tilt_rad, kNotANumber), {});
       }},
      {"mass_share",
       [&] { SuctionGrasps(box, cup.cup, rng, {}, With(&RobustOptions::mass_share, -1.0)); }},
      {"tip_steps", [&] { set_down(With(&PlaceOptions::tip_steps, 0)); }},
      {"gap_m",
       [&] {
         PlanPlace(scene.bin, box, Pose::Identity(), Pose::Identity(), {},
                   With(&PlaceOptions::gap_m, kNotANumber));
       }},
      {"friction", [&] { table(With(&TableOptions::friction, kNotANumber)); }},
      {"max_draws", [&] { DrawTableGrasps({}, 0, rng, With(&TableOptions::max_draws, 0)); }},
      {"folds", [&] { fit(With(&ToleranceFitOptions::folds, 0)); }},
      {"length_scale_m",
       [&] {
         EmptyToleranceModel(box, "jaw", {Pose::Identity()},
                             With(&ToleranceFitOptions::length_scale_m, 0.0));
       }},
  };
  ExpectRefused(planted);
}

}  // namespace
}  // namespace pickbed::tests
