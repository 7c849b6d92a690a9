#pragma once

// Scores of a segmentation of one image against labelled instances.
//
// Only pixels with a depth reading count. Sources of the measures:
// - weighted overlap: Silberman et al., "Indoor segmentation and support inference from RGBD
//   images", ECCV 2012. Mean over the instances of the largest IoU with any segment, weighted by
//   their pixels.
// - over- and under-segmentation: Richtsfeld et al., "Segmentation of unknown objects in indoor
//   environments", IROS 2012. Each segment is assigned to the instance that it covers most. An
//   instance is represented by its assigned segment with the most of its pixels.
//   over = 1 - true / all, with `true` the pixels of the instances inside their representing
//   segments, and `all` the pixels of all instances. under = false / all, with `false` the other
//   pixels of these segments.
// - under-segmentation error: Neubert and Protzel, "Superpixel benchmark and comparison", Forum
//   Bildverarbeitung 2012. Sum over instances and segments that overlap of the smaller part of the
//   segment, inside or outside of the instance, by the pixels of all instances.

#include <cstdint>
#include <vector>

#include "eval/layer.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// One labelled instance.
struct SegmentedInstance {
  int label = 0;
  int pixels = 0;          // with a reading
  double iou = 0;          // largest IoU with a segment
  int segment = 0;         // label of that segment; 0 = none overlaps
  int segments = 0;        // segments that are assigned to it
  double in_segment = 0;   // share of its pixels inside its representing segment
  bool is_counted = true;  // false: too little of it is visible for recall
};

// Scores of one image. All shares are 0..1.
struct SegmentScores {
  std::vector<SegmentedInstance> instances;  // by label
  int segments = 0;
  double weighted_overlap = 0;
  double over = 0;
  double under = 0;
  double under_error = 0;
  int matched_50 = 0, matched_75 = 0;  // segments with an IoU over .5, or at least .75
};

// Scores the labels of a segmentation. 0 = no segment in `labels`, background in `truth`. Both
// images must have one size; the labels may be any numbers. Throws std::logic_error if the sizes
// differ.
SegmentScores ScoreSegments(const Image<uint16_t>& labels, const Image<uint16_t>& truth);

}  // namespace pickbed::eval
