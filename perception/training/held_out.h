#pragma once

// Recall of a network on held-out patches, among the nearest entries of a small codebook. The query
// patches are from clutter scenes with other seeds than the training. The codebook contains a
// positive patch for each query, so each query has a right answer, and patches of random isolated
// views of all objects. An entry is right if its pose is within 0.1 diameter of the query's pose
// (maximum displacement, minimum over symmetries), the usual threshold of the field.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "perception/features/codebook.h"
#include "perception/training/positive_pairs.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

struct HeldOutOptions {
  int clutter_scenes = 3;  // per object
  int queries = 150;       // maximum number of queries per object
  int book_views = 300;    // isolated views per object in the codebook
  int every = 100;         // training steps per object between two measurements
  // Measurements without a gain before the schedule is shortened; 0 = never.
  int patience = 6;
  double gain = 0.005;    // minimum increase of recall@1 that counts as a gain
  double cooling = 0.15;  // share of all steps in which a shortened schedule ends
  void Visit(SettingsVisitor& v);
};

// Queries and codebook.
struct HeldOutSet {
  std::vector<PatchPairs> queries;        // by object: query patches and their positive patches
  std::vector<LabelledPatches> distract;  // by object: the other codebook patches
};

// Recall@1 and recall@8 of a network at one training step.
struct HeldOutRecall {
  int iteration = 0;
  double at_1 = 0, at_8 = 0;  // means over the objects
  // By object; -1 for an object without queries.
  std::vector<double> object_at_1;
  std::vector<double> object_at_8;
};

// One query and its nearest codebook entry, for display.
struct HeldOutAnswer {
  ObjectId object{0};
  int query = 0;           // row of queries[object].anchors
  Eigen::Vector3d view_O;  // unit vector from the object to the camera
  Eigen::VectorXf descriptor;
  ObjectId found_object{0};
  std::vector<int8_t> found;  // patch of the nearest entry
  bool right = false;
};

// Makes the set; the same seed gives the same set. `forms` is by object. on_share receives the
// progress, 0..1, and returns false to stop; the result is then incomplete.
HeldOutSet MakeHeldOut(LabelledViewSource& views, const std::vector<PatchForm>& forms,
                       const HeldOutOptions& options, uint64_t seed,
                       const std::function<bool(double share)>& on_share);

// Returns the recall of the descriptors; `iteration` is not set. `length` is the number of values
// of a descriptor.
HeldOutRecall MeasureRecall(const HeldOutSet& set, const ObjectSet& objects,
                            const DescribePatches& describe, int length);

// Returns up to `per_object` answers per object, in the order of the queries.
std::vector<HeldOutAnswer> AnswersOf(const HeldOutSet& set, const ObjectSet& objects,
                                     const DescribePatches& describe, int length, int per_object);

// Returns the index of the first measurement at which recall@1 has not increased by `gain` over its
// best for `patience` measurements; -1 if there is none.
int PlateauOf(const std::vector<HeldOutRecall>& history, const HeldOutOptions& options);

}  // namespace pickbed::perception
