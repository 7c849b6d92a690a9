#pragma once

// Grippers are data: assets/grippers/NAME.yaml names a mechanism and its numbers.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/bin.h"
#include "scenes/object_model.h"
#include "scenes/random.h"
#include "scenes/settings.h"
#include "sim/cup_joint.h"
#include "sim/hand_joints.h"
#include "sim/physics_world.h"

namespace pickbed {

struct GraspCandidate;         // grasp/grasp.h
struct GraspCandidateOptions;  // grasp/candidates.h

// Only the numbers of its own mechanism count.
struct GripperSpec {
  std::string name;
  std::string mechanism = "parallel_jaw";
  HandSpec hand;               // parallel_jaw
  CupSpec cup;                 // suction_cup
  double approach_m = 0.12;    // straight-line approach before the grasp
  double clearance_m = 0.003;  // kept between hand and anything else when planning
  // The keys of its mechanism: a file with another's is refused.
  void Visit(SettingsVisitor& v);
};

// A way to build a hand: one file in grippers/ and one row in gripper.cpp. Code elsewhere goes
// through the row and does not ask for the mechanism's name.
struct MechanismRow {
  const char* name;
  const char* help;
  // What x, y and z of G are, in words.
  std::array<const char*, 3> axes_G;
  // Names its own numbers.
  void (*visit)(GripperSpec& spec, SettingsVisitor& v);
  // Throws InputError naming `source` when the numbers contradict each other.
  void (*check)(const GripperSpec& spec, const std::string& source);
  // How far the hand is open on approach to a part of this width, m; nullopt = it cannot take it.
  std::optional<double> (*approach_opening_m)(const GripperSpec& spec, double width_m);
  double (*most_open_m)(const GripperSpec& spec);
  // From an opening until it is closed on nothing, and back, at its own speed, s.
  double (*travel_s)(const GripperSpec& spec, double opening_m);
  // Puts the hand into the world, open by this much, which is also as far as it opens there.
  Hand& (*add)(PhysicsWorld& world, const GripperSpec& spec, double opening_m, const Pose& X_WG);
  // The hand's solid boxes in G at an opening, for collision checks; the palm is the last.
  std::vector<AxisAlignedBox> (*boxes)(const GripperSpec& spec, double opening_m);
  // Where another part would be grasped along with the one that is meant, in G; nullopt = nowhere.
  std::optional<AxisAlignedBox> (*between)(const GripperSpec& spec, double opening_m);
  // What gives way and so stands in no collision check, for pictures.
  std::vector<AxisAlignedBox> (*soft_boxes)(const GripperSpec& spec);
  // The most that it can carry of a part of this friction, N: its weight must stay below.
  double (*capacity_n)(const GripperSpec& spec, double part_friction);
  // Its key numbers in a few words.
  std::string (*summary)(const GripperSpec& spec);
  const char* needs;  // what a part must have to be held so, in words
  // Grasps of a part with every quality, best first; empty when it cannot hold the part.
  std::vector<GraspCandidate> (*make_candidates)(const ObjectModel& model, const GripperSpec& spec,
                                                 Rng& rng, const GraspCandidateOptions& options);
};

std::span<const MechanismRow> MechanismTable();

// The row of the spec's mechanism; InputError for one that is not known.
const MechanismRow& MechanismOf(const GripperSpec& spec);

// NAME of assets/grippers or a path ending in .yaml. Throws InputError for an unknown name (with
// the nearest), a force or size that is not positive, a mechanism that is not known, or a key of
// another mechanism.
GripperSpec LoadGripper(const std::string& name_or_path);
std::vector<std::string> GripperNames();

// Both throw InputError, for use before anything is run. The hand at its narrowest, or as much of
// it as stands below the bin's rim when it reaches the floor, must fit between the walls.
void RequireFitsBin(const GripperSpec& gripper, const Bin& bin);
// The part's weight must be below the capacity.
void RequireCanCarry(const GripperSpec& gripper, const ObjectModel& part);

}  // namespace pickbed
