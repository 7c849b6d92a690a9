#pragma once

// Segments of unknown objects: the observed surface divided into objects without any object model.
//
// Neighbouring patches of surface belong to one object if their common border is smooth or convex,
// and to two objects if it is concave or a step in depth. This is the rule of locally convex
// connected patches (Stein et al., "Object partitioning using local convexity", CVPR 2014). The
// rule is applied to whole borders: every border has a weight, and the graph of patches is divided
// so that the weights agree (perception/segments/edge_contraction.h). So a short bridge does not
// join two objects.
//
//        convex: one object              concave: two objects           step: two objects
//            ____                          ____                        ____
//           /    \                        |    |____                  |    |
//          /      \                       |         |                      .___
//
// The result is an over-segmentation: an object with a concave edge, such as a bracket, has several
// segments.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/segments/surface_patches.h"

namespace pickbed::perception {

struct SegmenterOptions {
  PatchOptions patches;
  double flat_rad = 0.2;        // angle between patches up to which a border is smooth
  double concave_rad = 1.2;     // angle of a concave border that weighs as much as a smooth one
  double convex_weight = 0.6;   // weight of a sharp convex border, relative to a smooth one
  double concave_weight = 1.5;  // limit of the weight of concave borders; 0 = convexity is ignored
  double step_weight = 1.0;     // weight of a step in depth
  double color_weight = 0;      // weight of a color edge; 0 = color is ignored
  double color_step = 0.25;     // difference of colors, 0..1, that counts as a full edge
  int max_width_px = 800;       // wider images are binned before segmentation
  int join_px = 200;            // smaller segments are joined with a neighbour
  int min_px = 50;              // segments that are still smaller are left out
  double min_height_m = 0.006;  // height over the floor that a segment must reach, at 1 m
  void Visit(SettingsVisitor& v);
};

// A method: name, one line of help, and the options that it changes.
struct SegmenterRow {
  const char* name;
  const char* help;
  SegmenterOptions (*options)();
};
// Returns all methods; the first one is the default.
std::span<const SegmenterRow> SegmenterTable();
// Returns the row with this name. Throws InputError that lists the known names.
const SegmenterRow& SegmenterNamed(const std::string& name);

// One segment.
struct ObjectSegment {
  int pixels = 0;
  ImageBox box;                                        // contains all of its pixels
  Eigen::Vector3f center_C = Eigen::Vector3f::Zero();  // mean of its points, m
};

struct ObjectSegments {
  Image<uint16_t> labels;  // 0 = background or no reading; else index of the segment + 1
  std::vector<ObjectSegment> segments;
};

// Divides the foreground of a cloud into segments. An empty foreground gives no segments. Throws
// InputError for options out of range.
ObjectSegments SegmentCloud(const OrganizedCloud& cloud, const SegmenterOptions& options = {});

// Removes the background of a frame and divides the rest into segments, at the resolution of the
// frame. Floor and walls of a known bin are removed; without one, they are fitted. A frame without
// color is segmented by its depth. Throws InputError as BuildCloud() does.
ObjectSegments SegmentFrame(const RgbdFrame& frame,
                            const std::optional<KnownBackground>& background,
                            const SegmenterOptions& options = {});

}  // namespace pickbed::perception
