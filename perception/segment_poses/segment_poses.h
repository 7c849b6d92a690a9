#pragma once

// Raw poses of known objects from the completed shapes of occluded segments. The image is divided
// into segments without any object model. Each segment that something hides is completed, and its
// volume is looked up in the codebook of each object.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "perception/candidates/candidate_source.h"
#include "perception/segment_poses/volume_codebook.h"
#include "perception/segments/object_segments.h"

namespace pickbed::perception {

struct SegmentPoseOptions {
  CompletionOptions completion;  // set to fewer cells and turns by the constructor
  SegmenterOptions segmenter;
  int poses = 10;              // raw poses of each object for each segment
  double min_occluded = 0.05;  // share of its border at which an occluder hides a segment
  int max_segments = 60;       // segments that are completed, the largest first
  VolumeBookOptions book;
  SegmentPoseOptions();
  void Visit(SettingsVisitor& v);
};

// Inputs for making the codebooks.
struct SegmentPoseSetup {
  LabelledViewSource& views;
  std::filesystem::path cache_dir;                                       // empty = no cache
  std::function<void(std::string_view what, double share)> on_progress;  // may be empty
};

class SegmentPoses : public PoseProposer {
 public:
  // Makes the codebooks of setup.views.objects() or reads them from the cache. Throws InputError
  // for an unknown method of completion, and for a model file that is missing, damaged or of
  // another version.
  SegmentPoses(const SegmentPoseSetup& setup, const SegmentPoseOptions& options);

  // Segments with fewer than kMinSegmentPixels readings are skipped. Times are added under
  // "segments", "completion" and "volumes".
  std::vector<std::vector<PoseVote>> Propose(const OrganizedCloud& cloud,
                                             StageSeconds& seconds) const override;

 private:
  SegmentPoseOptions options_;
  std::unique_ptr<ShapeCompleter> completer_;
  std::vector<VolumeBook> books_;  // by object
};

// Returns the share of the segment's border pixels that have an occluder within two pixels.
// Without `view.occluders`, MarkOccluders() finds them.
double OccludedBorder(const SegmentView& view);

}  // namespace pickbed::perception
