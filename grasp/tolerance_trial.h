#pragma once

// Grasps of one part alone on a table, executed as a robot would that believes a wrong pose.
//
// A grasp is chosen where the part truly lies, as the planner chooses there. Then the pose is
// believed to be off by an error and the same grasp goes to where it belongs on the believed part:
// X_WG = X_WO_true * X_OO * X_OG. The table's place is known however wrong the part's is, so that
// the planner draws a hand that would meet it back along its approach, or gives the grasp up when
// nothing would be left of the contact: a lost pick (no_grasp).

#include <string>
#include <vector>

#include "grasp/execute.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/random.h"

namespace pickbed {

struct TableOptions {
  Eigen::Vector3d size_m{0.8, 0.8, 0};  // of the table: a bin without walls
  double friction = 0.5;                // of its top
  int drops = 100;                      // that the resting poses are found by
  double min_probability = 0.02;        // rarer resting poses are left alone
  double drop_m = 0.001;                // height from which the part comes to rest in its pose
  double settle_s = 2;                  // at most
  // Share of the part's candidates that one grasp is the planner's best of, at least `min_choice`:
  // many different grasps, each of which the planner might take.
  double choice_share = 0.05;
  int min_choice = 20;
  int max_draws = 20;  // of such a choice, each twice as large, until the planner finds a grasp
  void Visit(SettingsVisitor& v);
};

struct RestingPlace {
  Scene scene;             // the part, instance 0, as it came to rest on the table
  double probability = 0;  // share of drops that end so
  bool graspable = false;  // the planner finds a grasp when it knows the pose
};

struct Table {
  ObjectSet objects;  // the part
  GripperSpec gripper;
  std::vector<GraspCandidate> candidates;
  std::vector<RestingPlace> places;  // most frequent first
};

// Throws InputError when there are no candidates, or none that the table leaves free in any resting
// pose; the message names part and gripper. The part must have convex pieces (std::logic_error).
Table MakeTable(std::shared_ptr<const ObjectModel> part, const GripperSpec& gripper,
                std::vector<GraspCandidate> candidates, const TableOptions& options = {});

struct TableGrasp {
  int place = 0;
  GraspCandidate candidate;
};

// `count` grasps spread over the graspable places as the part comes to rest in them.
std::vector<TableGrasp> DrawTableGrasps(const Table& table, int count, Rng& rng,
                                        const TableOptions& options = {});

// Executes the grasp on the pose that is off by `X_OtrueObelieved`. Same inputs, same outcome.
GraspOutcome ExecuteWithError(const Table& table, const TableGrasp& grasp,
                              const Pose& X_OtrueObelieved, const ExecuteOptions& options = {});

}  // namespace pickbed
