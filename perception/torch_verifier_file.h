#pragma once

// A file of verifiers, for an estimator that learns little else: which of that estimator's own
// candidates are right; and what it learned to find these candidates, where it did.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/torch_model_file.h"

namespace pickbed {

// A network that an estimator's candidates come from, as that estimator reads it.
struct LearnedNetwork {
  std::string settings;  // empty = there is none
  std::vector<float> weights;
};

struct VerifierFile {
  std::string estimator;             // whose candidates they judge
  std::string sensor;                // profile of the training views
  std::string training;              // effective settings: two files of equal ones are comparable
  std::vector<ModelObject> objects;  // side_m is unused
  std::vector<Verifier> verifiers;   // of each object
  LearnedNetwork network;
};

void SaveVerifiers(const std::filesystem::path& file, const VerifierFile& content);

// Throws InputError naming the file: absent, damaged, no such file, of another version, or made
// for another estimator than `estimator`.
VerifierFile LoadVerifiers(const std::filesystem::path& file, const std::string& estimator);

}  // namespace pickbed
