#pragma once

// How much of each segment continues under other surfaces.
//
// Where the surface beyond the contour of a segment is nearer to the camera, it covers the segment,
// and the object goes on behind it. An object that others cover is held down and is hard to pull
// out.
//
//          camera
//            |                covered: the neighbour is nearer
//       ____ v
//      |    |________|        free: the neighbour is farther, or as far
//      |____|
//           ^        ^
//        covered    free

#include <vector>

#include "perception/segments/object_segments.h"

namespace pickbed::perception {

struct CoverOptions {
  double step_m = 0.003;  // a neighbour that is nearer by more covers the segment
  int search_px = 4;      // distance in which a reading beyond the contour is searched
  void Visit(SettingsVisitor& v);
};

// Returns the covered share of the contour of each segment, 0..1. A contour is counted in pairs of
// a pixel and the next reading outside of its segment, in eight directions. Pairs without a reading
// within `search_px` do not count; without any pair the share is 0.
// - depth_m: depth image of the segments (m); pixels without a reading are 0
// Throws InputError for options out of range.
std::vector<double> CoveredShares(const Image<float>& depth_m, const ObjectSegments& segments,
                                  const CoverOptions& options = {});

}  // namespace pickbed::perception
