#pragma once

// Planner without poses that grasps unknown objects on their completed shapes. It knows the camera,
// the grippers and, if given, the bin, but no object.
//
// A source gives the occupancy of each object that the image shows
// (grasp/completed/occupancy_shape.h). The surface at a probability near one half takes the place
// of a CAD mesh: grasp candidates are sampled on it, and the planner on poses (grasp/plan/plan.h)
// checks and ranks them against the bin, the observed points, the other objects and the space that
// the image does not show. Jaws also grasp the observed surface (grasp/cloud/cloud_antipodal.h).
// The score of a grasp is its estimated chance of success, so that both kinds of grasps are ranked
// together: by a logistic function (grasp/completed/success_chance.h), or for jaws by a network if
// the scenario names one (grasp/completed/success_network.h). With PlannerSpec::rehearsals, the
// best grasps of jaws are rehearsed in physics on the completed shapes
// (grasp/completed/rehearsal.h), which lowers their chances if they fail.
//
//          p > surface_level: grasped surface      A hand also keeps out of possible matter, where
//          ______                                  the probability is over `possible_level`. A jaw
//         |  __  |                                 opens wider to pass it.
//         | |  | |  p > possible_level: fingers
//         | |__| |  keep out
//         |______|

#include <memory>
#include <span>
#include <vector>

#include "grasp/candidates/candidates.h"
#include "grasp/completed/completed_object.h"
#include "grasp/completed/grasp_rater.h"
#include "grasp/completed/occupancy_shape.h"
#include "grasp/completed/rehearsal.h"
#include "grasp/completed/success_chance.h"
#include "grasp/plan/clearance.h"
#include "grasp/plan/planner.h"

namespace pickbed::grasp {

struct CompletedPlannerOptions {
  int max_shapes = 10;                     // objects that are completed, from the highest one
  int smoothing = 2;                       // passes of Smoothed()
  bool grasps_observed = true;             // hands also grasp the observed surface
  SuccessChance chance = {};               // score of a grasp without a network
  double min_reported_score = 0.05;        // smallest chance before rehearsals that is reported
  double surface_level = kSurfaceLevel;    // probability at the grasped surface
  double possible_level = kPossibleLevel;  // probability from which a hand keeps out
  double relaxed_level = 0.5;              // the same if no grasp is found otherwise
  double wider_m = 0.003;                 // step by which a jaw opens wider to pass possible matter
  int max_wider = 6;                      // number of these steps
  int max_candidates = 120;               // candidates of an object for one jaw, from above
  double density_kgpm3 = 1500;            // assumed density of an object
  int tested_grasps = 300;                // planned grasps that are tested against possible matter
  PlanOptions plan = {};                  // max_grasps, seed and max_tilt_rad are set by each call
  GraspCandidateOptions candidates = {};  // set to fewer samples by the constructor
  RehearsalOptions rehearsal = {};
  CompletedPlannerOptions();
  void Visit(SettingsVisitor& v);
};

class CompletedPlanner : public Planner {
 public:
  // Throws InputError without PlannerSetup::shapes, and for options out of range.
  explicit CompletedPlanner(const PlannerSetup& setup, const CompletedPlannerOptions& options = {});

  // Without a known bin, the lowest observed point is taken as the height of a table. Causes of
  // rejection: as PlanWithTools(), as CloudAntipodal, "possible matter", "score too low", and
  // "segment without shape", which counts segments.
  // Without objects, jaws and cups grasp the observed surface if `grasps_observed`.
  PlanResult Plan(const PlannerInput& input) override;

 private:
  double MaxTilt_rad() const;              // of an approach from straight down, in the first pass
  CompletedObjectOptions Assumed() const;  // properties of the objects
  PlanResult PlanOn(const std::vector<CompletedObject>& objects, const GraspRater& rater,
                    const PlannerInput& input, const BinPlacement& bin) const;
  const Gripper& ToolOf(const Grasp& grasp) const;
  // Removes the grasps of the completed and of the observed surface at which a hand enters possible
  // matter, or matter from `relaxed_level` if all of them do. A jaw may open wider to pass.
  void KeepOutOfPossibleMatter(std::span<const OccupancyShape> shapes, const Pose& X_BW,
                               PlanResult& plan, PlanResult& observed) const;
  bool Passes(const ObstacleField& matter, const Pose& X_BW, Grasp& grasp) const;
  // Returns the chance that a grasp of a surface succeeds.
  double ChanceOf(const Grasp& grasp, GraspedSurface surface, const GraspRater& rater) const;
  // Rehearses the jaws' grasps with the best chances and lowers these, until the best `max_grasps`
  // are rehearsed, or PlannerSpec::rehearsals of them, or the others are under
  // PlannerSpec::min_score. `grasps` are sorted by their chances before and after it.
  void Rehearse(Rehearsal& rehearsal, int max_grasps, std::vector<Grasp>& grasps) const;

  const PlannerSetup setup_;
  const CompletedPlannerOptions options_;
  std::vector<std::unique_ptr<Planner>> on_surface_;  // of jaws and of cups; empty: none
};

}  // namespace pickbed::grasp
