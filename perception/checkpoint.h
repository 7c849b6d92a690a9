#pragma once

// What an interrupted training goes on from.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/held_out.h"
#include "perception/torch_verifier.h"

namespace pickbed {

struct Checkpoint {
  std::string key;  // settings and parts; another key cannot go on from it
  int iteration = 0;
  std::vector<double> loss_history;
  std::vector<HeldOutRecall> recall_history;  // all of the same parts
  std::string training_state;                 // DescriptorNetwork::TrainingState()
  std::vector<TrainedVerifier> verifiers;     // those done, in the order of their training
};

void WriteCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);

// Throws InputError naming the file when it is missing, damaged or has another key.
Checkpoint ReadCheckpoint(const std::filesystem::path& file, const std::string& key);

}  // namespace pickbed
