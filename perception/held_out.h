#pragma once

// How well a network finds poses on patches that it never learns from: recall among the nearest
// entries of a small code book. The patches are cut from piles of seeds apart from training's; the
// book holds a near twin of each, so that every one of them has a right answer, and patches of
// isolated views at random poses of all parts. Right: the entry's pose is within 0.1 diameter of
// the patch's (largest displacement, least over symmetries), the field's usual threshold.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "perception/codebook.h"
#include "perception/twin_patches.h"

namespace pickbed {

struct HeldOutOptions {
  int piles = 3;          // per part
  int queries = 150;      // per part at most
  int book_views = 300;   // isolated views per part that fill the code book
  int every = 100;        // steps per part between two measurements
  int patience = 6;       // measurements without a gain before the schedule is cut short; 0 = never
  double gain = 0.005;    // of recall among the first, to count as one
  double cooling = 0.15;  // of the steps: what is left of the schedule is then run through in these
  void Visit(SettingsVisitor& v);
};

struct HeldOutSet {
  std::vector<PatchPairs> queries;        // by part: patches of piles and their twins
  std::vector<LabelledPatches> distract;  // by part: what else the code book holds
};

// Of a network at one step.
struct HeldOutRecall {
  int iteration = 0;
  double at_1 = 0, at_8 = 0;      // means over parts
  std::vector<double> part_at_1;  // by part; -1 for a part without queries
  std::vector<double> part_at_8;  //
};

// One query with what was found for it, for people.
struct HeldOutAnswer {
  int part = 0;
  int query = 0;           // row of queries[part].anchors
  Eigen::Vector3d view_O;  // unit vector from the part's frame towards the camera
  Eigen::VectorXf descriptor;
  int found_part = 0;
  std::vector<int8_t> found;  // the nearest entry's patch
  bool right = false;
};

// on_share(0..1) returns false to stop; what comes back is then unfinished. forms: of the patches,
// by part. The same seed gives the same set.
HeldOutSet MakeHeldOut(LabelledViewSource& views, const std::vector<PatchForm>& forms,
                       const HeldOutOptions& options, uint64_t seed,
                       const std::function<bool(double share)>& on_share);

HeldOutRecall MeasureRecall(const HeldOutSet& set, const ObjectSet& objects,
                            const DescribePatches& describe, int length);

// Up to `per_part` answers of each part, in the order of the queries.
std::vector<HeldOutAnswer> AnswersOf(const HeldOutSet& set, const ObjectSet& objects,
                                     const DescribePatches& describe, int length, int per_part);

// Index of the measurement at which recall among the first has not grown by `gain` over its best
// for `patience` measurements; -1 where it never came to that.
int PlateauOf(const std::vector<HeldOutRecall>& history, const HeldOutOptions& options);

}  // namespace pickbed
