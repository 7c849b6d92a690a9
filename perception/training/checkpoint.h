#pragma once

// Checkpoint file, from which an interrupted training resumes.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/training/held_out.h"
#include "perception/training/verifier_fit.h"

namespace pickbed::perception {

// State of a training.
struct Checkpoint {
  std::string key;  // settings and objects; a training with another key cannot resume from it
  int iteration = 0;
  std::vector<double> loss_history;
  std::vector<HeldOutRecall> recall_history;  // all entries have the same objects
  std::string training_state;                 // DescriptorNetwork::TrainingState()
  std::vector<TrainedVerifier> verifiers;     // finished ones, in the order of their training
};

// Writes the file atomically.
void WriteCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);

// Throws InputError naming the file if it is missing, damaged or has another key.
Checkpoint ReadCheckpoint(const std::filesystem::path& file, const std::string& key);

}  // namespace pickbed::perception
