#include "perception/completion_networks/network_options.h"

#include "perception/completion_networks/completion_net.h"

namespace pickbed::perception {

std::vector<std::string> CompletionKinds() {
  std::vector<std::string> names;
  for (const CompletionNetRow& row : CompletionNetTable()) names.push_back(row.name);
  return names;
}

void CompletionNetworkOptions::Visit(SettingsVisitor& v) {
  v.Text("kind", kind, CompletionKinds(), "kind of network");
  v.Integer("width_16", width_16, {4, 256}, "channels of the layers with 16^3 cells");
  v.Integer("width_8", width_8, {4, 256}, "channels of the layers with 8^3 cells");
  v.Integer("width_4", width_4, {4, 256}, "channels of the layers with 4^3 cells");
  v.Integer("bottleneck", bottleneck, {4, 4096}, "values that describe the whole cube");
  v.Integer("image_width", image_width, {4, 256},
            "kind implicit: channels of the image layers with 64^2 pixels; coarser ones have more");
  v.Integer("hidden", hidden, {4, 1024}, "units of each hidden layer of the decoder");
  v.Integer("rounds", rounds, {1, 10000},
            "kind vae: rounds of reconstruction, sampling and clamping for a completion");
}

}  // namespace pickbed::perception
