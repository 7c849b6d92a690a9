#pragma once

// A file of verifiers alone, for an estimator that learns nothing else: which of that estimator's
// own candidates are right.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/torch_model_file.h"

namespace pickbed {

struct VerifierFile {
  std::string estimator;             // whose candidates they judge
  std::string sensor;                // profile of the training views
  std::string training;              // effective settings: two files of equal ones are comparable
  std::vector<ModelObject> objects;  // side_m is unused
  std::vector<Verifier> verifiers;   // of each object
};

void SaveVerifiers(const std::filesystem::path& file, const VerifierFile& content);

// Throws InputError naming the file: absent, damaged, no such file, of another version, or made
// for another estimator than `estimator`.
VerifierFile LoadVerifiers(const std::filesystem::path& file, const std::string& estimator);

}  // namespace pickbed
