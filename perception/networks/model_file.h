#pragma once

// File of a trained descriptor model: weights, verifiers, and a description of the training and of
// the objects.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/networks/descriptor_network.h"
#include "perception/verify/pose_features.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

inline constexpr const char* kTrainCommand = "`pickbed train`";

// An object that a model was trained for.
struct ModelObject {
  std::string name;
  uint64_t mesh_hash = 0;
  double diameter_m = 0;
  double side_m = 0;        // patch side
  double verifier_auc = 0;  // area under the verifier's ROC curve on held-out poses
  double recall_at_1 = -1;  // on held-out patches, see held_out.h; -1 = not measured
  double recall_at_8 = -1;
  void Visit(SettingsVisitor& v);
};

// Description of a model and of its training.
struct ModelInfo {
  std::vector<ModelObject> objects;
  std::string sensor;  // sensor profile of the training views
  NetworkOptions network;
  int iterations = 0;                         // training steps done
  double loss = 0;                            // mean of the last hundred steps
  double recall_at_1 = -1, recall_at_8 = -1;  // on held-out patches, mean over the objects
  void Visit(SettingsVisitor& v);

  // Effective settings of the training, for information only. Visit() does not read them, so a
  // renamed setting makes no model unreadable.
  std::string training;
};

// A loaded model.
struct DescriptorModel {
  ModelInfo info;
  DescriptorNetwork network;
  std::vector<Verifier> verifiers;  // one per info.objects
  uint64_t network_hash = 0;        // hash of the weights; part of the key of codebooks
  uint64_t hash = 0;                // hash of weights and verifiers
};

// Writes a model; `verifiers` has one entry per info.objects. Throws InputError naming the file if
// it cannot be written.
void SaveModel(const std::filesystem::path& file, const ModelInfo& info,
               const DescriptorNetwork& network, const std::vector<Verifier>& verifiers);
// Reads a model. Throws InputError naming the file if it is absent, damaged, no model, or of an
// unsupported version. The message recommends `command`, which trains such a model.
DescriptorModel LoadModel(const std::filesystem::path& file,
                          const std::string& command = kTrainCommand);

// Returns the index into `trained` of each object. Throws InputError if the model was not trained
// for an object, or if its mesh has changed since. The message names file, object and `command`.
std::vector<int> TrainedObjects(const std::vector<ModelObject>& trained, const ObjectSet& objects,
                                const std::filesystem::path& file,
                                const std::string& command = kTrainCommand);

}  // namespace pickbed::perception
