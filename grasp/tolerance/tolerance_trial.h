#pragma once

// Executes grasps of a single object on a table with a given pose error.
//
// A grasp is chosen at the true pose, as the planner chooses there. Then the estimated pose has an
// error, and the same grasp goes to its place on the estimated object: X_WG = X_WO_true *
// X_OE * X_OG. The pose of the table is always known. So the planner retracts a hand
// that would meet it along its approach. It rejects the grasp if no contact would remain; this is a
// failed pick (no_grasp).

#include <memory>
#include <string>
#include <vector>

#include "grasp/execute/execute.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/base/random.h"

namespace pickbed::grasp {

// Options of the table and of the choice of grasps on it.
struct TableOptions {
  Eigen::Vector3d size_m{0.8, 0.8, 0};  // of the table: a bin without walls
  double friction = 0.5;                // of the table top
  int drops = 100;                      // drops from which the resting poses are found
  double min_probability = 0.02;        // rarer resting poses are ignored
  double drop_m = 0.001;                // height from which the object settles in its resting pose
  double settle_s = 2;                  // maximum time to settle
  // A grasp is the best of the planner on a random subset of the candidates: this share, at least
  // `min_choice`. This gives many different grasps, each of which the planner might select.
  double choice_share = 0.05;
  int min_choice = 20;
  int max_draws = 20;  // subsets until the planner finds a grasp, each twice as large
  void Visit(SettingsVisitor& v);
};

// Resting pose of the object on the table.
struct RestingPlace {
  Scene scene;             // the object, instance 0, at rest on the table
  double probability = 0;  // share of drops that end in this resting pose
  bool graspable = false;  // the planner finds a grasp for the true pose
};

// Drops the object on a table and returns its resting poses, most frequent first, without
// `graspable`. The object must have convex pieces (std::logic_error).
std::vector<RestingPlace> RestingPlacesOf(const ObjectModel& object,
                                          const TableOptions& options = {});

// Table with one object and its grasp candidates.
struct Table {
  ObjectSet objects;  // the single object
  std::shared_ptr<const Gripper> gripper;
  std::vector<GraspCandidate> candidates;
  std::vector<RestingPlace> places;  // most frequent first
};

// Finds the resting poses of an object on a table. Throws InputError if there are no candidates, or
// if the table leaves none of them free in any resting pose; the message names object and gripper.
// The object must have convex pieces (std::logic_error).
Table MakeTable(std::shared_ptr<const ObjectModel> object, std::shared_ptr<const Gripper> gripper,
                std::vector<GraspCandidate> candidates, const TableOptions& options = {});

// Grasp at the object in one of Table::places.
struct TableGrasp {
  int place = 0;
  GraspCandidate candidate;
};

// Draws up to `count` grasps, distributed over the graspable places by their probability.
std::vector<TableGrasp> DrawTableGrasps(const Table& table, int count, Rng& rng,
                                        const TableOptions& options = {});

// Executes the grasp with the pose error `X_OE`. Equal inputs give equal outcomes.
GraspOutcome ExecuteWithError(const Table& table, const TableGrasp& grasp, const Pose& X_OE,
                              const ExecuteOptions& options = {});

}  // namespace pickbed::grasp
