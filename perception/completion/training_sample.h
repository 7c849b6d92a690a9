#pragma once

// Training samples of the completion network: a random view of a sampled shape as network input,
// and random points with the truth.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/completion/completion_network.h"
#include "perception/completion/random_view.h"
#include "scenes/shape_families/shape_family.h"

namespace pickbed::perception {

// Network input of a view, queries and truth.
struct CompletionSample {
  std::vector<int8_t> channels;  // CompletionInput::Channels()
  std::vector<float> image;      // CompletionInput::ImageChannels()
  std::vector<float> queries;    // points x kQueryValues
  std::vector<uint8_t> inside;   // points, 1 = inside the solid
  std::vector<int8_t> volume;    // kInputCells^3, 127 = inside; empty if not wanted
};

// Makes a sample with this number of uniform points of the cube that are not known to be empty.
CompletionSample MakeSample(const ViewedSolid& solid, const RandomView& drawn, int points, Rng& rng,
                            bool with_volume = false);

// A sample and the turn (see completion_input.h) with which it is used.
struct TurnedSample {
  const CompletionSample* sample;
  int turn;
};

// Returns a batch of samples that have equal numbers of points, computed by `threads` threads.
CompletionBatch BatchOf(std::span<const TurnedSample> samples, int threads = 1);

// Returns a solid that is sphere traced from a sampled shape.
std::unique_ptr<ViewedSolid> SolidOf(SolidShape shape);

// What the samples of a training are drawn from.
struct CompletionSource {
  std::vector<const ShapeFamilyRow*> families;
  ShapeSplit split = ShapeSplit::kSeen;
  std::vector<DepthSensor> sensors;  // each view uses one of them; empty = ideal depth
  RandomViewOptions views;
  int points = 2048;        // for each sample
  int views_per_shape = 4;  // samples of a group
  bool volumes = false;     // whether samples have volumes
};

// Draws a shape and its samples. The result depends only on the arguments.
std::vector<CompletionSample> DrawGroup(const CompletionSource& source, uint64_t seed,
                                        int64_t group);

}  // namespace pickbed::perception
