#pragma once

// Model file of a completion network. Weights are stored as 16-bit floats, the statistics of the
// normalizations as 32-bit floats.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/completion/completion_network.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

// Facts about a trained network.
struct CompletionModelInfo {
  CompletionNetworkOptions network;
  std::vector<std::string> domains;   // shape domains
  std::vector<std::string> families;  // shape families in the training
  std::vector<std::string> sensors;   // sensor profiles of the training views
  int steps = 0;                      // training steps done
  double loss = -1;                   // on held-out views, -1 = not measured
  double iou = -1;                    // on points of held-out views, -1 = not measured
  std::string training;               // settings of the training
  void Visit(SettingsVisitor& v);
};

struct CompletionModel {
  CompletionModelInfo info;
  CompletionNetwork network;
};

// Writes the file atomically. The same network gives the same bytes.
void SaveCompletionModel(const std::filesystem::path& file, const CompletionModelInfo& info,
                         const CompletionNetwork& network);

// Throws InputError that names the file if it is missing, cut short, damaged, of another kind or
// of a newer version.
CompletionModel LoadCompletionModel(const std::filesystem::path& file,
                                    const std::string& device = "cpu");

}  // namespace pickbed::perception
