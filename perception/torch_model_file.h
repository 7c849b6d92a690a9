#pragma once

// The trained model as one file: weights, verifier, and all that it was trained with and for.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/torch_network.h"
#include "perception/verify.h"
#include "scenes/object_model.h"

namespace pickbed {

inline constexpr const char* kTrainCommand = "pickbed train";

struct ModelObject {
  std::string name;
  uint64_t mesh_hash = 0;
  double diameter_m = 0;
  double side_m = 0;        // of its patches
  double verifier_auc = 0;  // of its verifier, on held-out poses
  double recall_at_1 = -1;  // of held-out patches, see held_out.h; -1 = not measured
  double recall_at_8 = -1;
  void Visit(SettingsVisitor& v);
};

struct ModelInfo {
  std::vector<ModelObject> objects;  // what it was trained for
  std::string sensor;                // profile of the training views
  NetworkOptions network;
  int iterations = 0;                         // done
  double loss = 0;                            // mean of the last hundred
  double recall_at_1 = -1, recall_at_8 = -1;  // of held-out patches, mean over parts
  void Visit(SettingsVisitor& v);

  // Effective settings of the training, for people; kept apart, so that a renamed setting makes no
  // model unreadable.
  std::string training;
};

struct DescriptorModel {
  ModelInfo info;
  DescriptorNetwork network;
  std::vector<Verifier> verifiers;  // of each of info.objects
  uint64_t network_hash = 0;        // of the weights: the key of code books
  uint64_t hash = 0;                // of weights and verifiers
};

// Both throw InputError naming the file: not readable, damaged, not a model, of a newer version.
void SaveModel(const std::filesystem::path& file, const ModelInfo& info,
               const DescriptorNetwork& network, const std::vector<Verifier>& verifiers);
// `command` trains such a model.
DescriptorModel LoadModel(const std::filesystem::path& file,
                          const std::string& command = kTrainCommand);

// Index into `trained` of each part. Throws InputError naming file and part for one that the model
// was not trained for or whose mesh has changed since, and the command that trains it.
std::vector<int> TrainedParts(const std::vector<ModelObject>& trained, const ObjectSet& objects,
                              const std::filesystem::path& file,
                              const std::string& command = kTrainCommand);

// A trained model by its path, or by its name under assets/models.
std::filesystem::path TrainedFile(const std::string& name);

}  // namespace pickbed
