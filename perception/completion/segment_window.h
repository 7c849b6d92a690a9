#pragma once

// The part of an image around one of its segments.

#include "perception/completion/segment_view.h"
#include "perception/segments/object_segments.h"

namespace pickbed::perception {

// Returns the view of a segment: the window of the image around it. The images have the size of the
// intrinsics.
// - labels: pixels of the segment have the value `label`
// - margin: width of the window beyond the segment, as a share of its larger side
SegmentView SegmentWindow(const Image<float>& depth_m, const CameraIntrinsics& intrinsics,
                          const Image<uint16_t>& labels, const ObjectSegment& segment, int label,
                          double margin = 0.75);

}  // namespace pickbed::perception
