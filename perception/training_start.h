#pragma once

// What a training begins with: fresh weights, or a model that may know some of the parts.

#include <optional>
#include <vector>

#include "perception/torch_model_file.h"
#include "perception/training.h"

namespace pickbed {

struct TrainingStart {
  std::optional<DescriptorModel> model;
  std::vector<int> known;  // by part: index into the model's objects, -1 = a new part
  bool rehearses = false;  // some parts are known and some are new

  bool IsRehearsed(size_t part) const { return rehearses && known[part] >= 0; }
};

// A part whose mesh has changed is a new one. Throws InputError as LoadModel does and for a network
// of another kind or length.
TrainingStart LoadTrainingStart(const TrainingJob& job, const TrainingOptions& options);

// By part: 1, of rehearsed ones options.rehearsal.
std::vector<double> PartWeights(const TrainingStart& start, const TrainingOptions& options);

// Patch side by part; known parts keep theirs.
std::vector<double> StartSides(const ObjectSet& objects, const TrainingStart& start,
                               const TrainingOptions& options);

// What a checkpoint belongs to: settings, views and parts, without what may change between two
// sessions of one training. start_hash: of the weights it begins with; 0 = fresh ones.
std::string CheckpointKey(const LabelledViewSource& views, TrainingOptions options,
                          const std::string& sensor, uint64_t start_hash);

}  // namespace pickbed
