#pragma once

// What a training does when: how many steps and piles there are, whose turn it is, how many piles
// are in at a step, and how far the learning rate has come along its cosine. All follows from
// settings and from the recall that was measured, never from the time.

#include <vector>

#include "perception/training.h"

namespace pickbed {

// `count` parts one after the other, each as often as its weight says and spread evenly: of equal
// weights 0, 1, 2, ..., 0, 1, ... Throws std::logic_error unless all weights are above 0.
std::vector<int> TakeTurns(const std::vector<double>& weights, int count);

class TrainingSchedule {
 public:
  // weights: of the parts, 1 = as many piles and steps as the options say.
  TrainingSchedule(const std::vector<double>& weights, const TrainingOptions& options);

  int iterations() const { return iterations_; }
  int piles() const { return static_cast<int>(pile_parts_.size()); }
  const std::vector<int>& main_parts() const { return main_parts_; }  // of each step's batch
  const std::vector<int>& pile_parts() const { return pile_parts_; }  // in each pile for certain
  int measure_every() const { return measure_every_; }                // steps

  // Looks whether recall stays on a plateau.
  void Watch(const std::vector<HeldOutRecall>& history);
  int plateau_iteration() const { return plateau_iteration_; }  // -1 = none

  // Of the schedule that lies behind after so many steps; 1 and more = done. After a plateau the
  // rest of it is run through in few steps: weights that were never cooled are worse.
  double Share(int iteration) const;

  // Piles that are in at that share, in steps enough for each to be seen; no more after a plateau.
  int WantedPiles(double share) const;
  int FirstPiles() const;

 private:
  HeldOutOptions held_out_;
  double views_share_ = 1;
  int iterations_ = 0;
  int measure_every_ = 1;
  int plateau_iteration_ = -1;
  std::vector<int> main_parts_;
  std::vector<int> pile_parts_;
};

}  // namespace pickbed
