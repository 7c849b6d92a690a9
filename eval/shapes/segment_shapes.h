#pragma once

// Shapes of the unknown objects in an image, for grasp::CompletedPlanner: the segments of the
// image, completed by a method of perception or by the ground truth.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/shapes/completion_choice.h"
#include "grasp/completed/occupancy_shape.h"
#include "perception/completion/shape_completer.h"
#include "perception/segments/object_segments.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// Ground truth of an image, for kTrueShapes. References must outlive the next call of Shapes().
struct TrueShapes {
  const Scene& scene;
  const ObjectSet& objects;    // in their true sizes
  const Image<uint16_t>& ids;  // instance + 1, 0 = background
};

class SegmentShapes : public grasp::ShapeSource {
 public:
  // - segmentation: a row of perception::SegmenterTable()
  // - completion: kTrueShapes, or a row of perception::CompleterTable()
  // Throws InputError for an unknown name, and for a model file that cannot be read.
  SegmentShapes(const std::string& segmentation, const std::string& completion);

  // Sets the ground truth of the next image; null = none.
  void SetTruth(const TrueShapes* truth) { truth_ = truth; }

  // Segments the image and completes the highest segments with at least
  // perception::kMinSegmentPixels readings. Throws InputError for kTrueShapes without truth.
  std::vector<grasp::OccupancyShape> Shapes(const grasp::PlannerInput& input,
                                            int max_shapes) override;
  grasp::ImageSegments Segments() const override;

 private:
  std::optional<grasp::OccupancyShape> ShapeOf(const grasp::PlannerInput& input, int label,
                                               std::vector<int>& used_instances) const;

  const perception::SegmenterOptions options_;
  const bool is_true_;
  std::unique_ptr<perception::ShapeCompleter> completer_;  // null for the truth
  const TrueShapes* truth_ = nullptr;
  perception::ObjectSegments segments_;  // of the last image
  std::vector<double> covered_;          // share of the contour of each of these segments
  int without_shape_ = 0;                // number of tried ones that got no shape
};

// Gives the ground truth of an image to the shapes, if there are any, until it is destroyed.
class TruthOfImage {
 public:
  TruthOfImage(SegmentShapes* shapes, const TrueShapes& truth) : shapes_(shapes), truth_(truth) {
    if (shapes_ != nullptr) shapes_->SetTruth(&truth_);
  }
  ~TruthOfImage() {
    if (shapes_ != nullptr) shapes_->SetTruth(nullptr);
  }
  TruthOfImage(const TruthOfImage&) = delete;
  TruthOfImage& operator=(const TruthOfImage&) = delete;

 private:
  SegmentShapes* shapes_;
  TrueShapes truth_;
};

// Returns the view of one segment: the window of the image around it.
// - margin: width of the window beyond the segment, as a share of its larger side
perception::SegmentView ViewOf(const RgbdFrame& frame, const Image<uint16_t>& labels,
                               const perception::ObjectSegment& segment, int label,
                               const std::optional<perception::FloorPlane>& floor,
                               double margin = 0.75);

// Returns the occupancy of a mesh on a grid of `cells` cells along each axis around it, 1 inside
// and 0 outside.
grasp::OccupancyShape ShapeOfMesh(const TriangleMesh& mesh_O, const Pose& X_WO, int cells = 64);

}  // namespace pickbed::eval
