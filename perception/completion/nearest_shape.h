#pragma once

// Completion by the nearest of many training views: the view whose channels differ least, in one of
// eight turns of the cube, gives its true shape.

#include <memory>
#include <vector>

#include "perception/completion/shape_completer.h"
#include "perception/completion/training_sample.h"

namespace pickbed::perception {

// A library of training views with ideal depth.
class NearestShape : public ShapeCompleter {
 public:
  // Draws `count` views of seen shapes of these families.
  NearestShape(const std::vector<const ShapeFamilyRow*>& families, int count, int cells);
  CompletedVolume Complete(const SegmentView& view) override;

 private:
  struct Entry {
    int solid = 0;  // index in solids_
    Pose X_CO;
    CompletionCube cube;
    std::vector<int8_t> coarse;  // channels, averaged over blocks of cells
  };
  int cells_;
  std::vector<std::unique_ptr<ViewedSolid>> solids_;
  std::vector<Entry> entries_;
};

}  // namespace pickbed::perception
