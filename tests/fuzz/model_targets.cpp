#include "eval/success/grasp_examples.h"
#include "grasp/completed/success_network.h"
#include "perception/completion/completion_file.h"
#include "perception/completion_networks/network_options.h"
#include "perception/networks/model_file.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/checkpoint.h"
#include "perception/training/shared_verifier.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"
#include "tests/support/block_file.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModel = "a.net";

Contents ModelAsset(const std::string& name) {
  return {ReadFileBytes(AssetsDir() / "models" / name)};
}

// One of each kind. The shipped model has 2.6 MB of weights, so that few mutations would hit the
// rest.
Contents SmallCompletionModels() {
  Contents contents;
  for (const std::string& kind : CompletionKinds()) {
    CompletionModelInfo info;
    info.network.kind = kind;
    info.network.width_16 = info.network.width_8 = info.network.width_4 = 4;
    info.network.bottleneck = info.network.image_width = 4;
    info.network.hidden = 16;
    contents.push_back(BytesOfFile(kModel, [&](const fs::path& file) {
      SaveCompletionModel(file, info, CompletionNetwork(info.network));
    }));
  }
  return contents;
}

Contents SharedVerifiers() {
  return {BytesOfFile(kModel, [](const fs::path& file) {
    SaveSharedVerifier(file, LoadModel(AssetsDir() / "models" / "shipped.net").verifiers[0].unknown,
                       "kinect_v1", "verifier.hidden 24");
  })};
}

constexpr const char* kKey = "settings and objects";

Contents Checkpoints() {
  Checkpoint checkpoint;
  checkpoint.key = kKey;
  checkpoint.iteration = 7;
  checkpoint.loss_history = {0.5, 0.25};
  checkpoint.recall_history = {{0, 0.1, 0.4, {0.2, -1}, {0.5, -1}}};
  checkpoint.training_state = std::string("\0state\xff", 7);
  const std::vector<Verifier> known = LoadModel(AssetsDir() / "models" / "shipped.net").verifiers;
  checkpoint.verifiers = {{known[0], 0.9}, {known[0], 0.8}};
  return {BytesOfFile(kModel, [&](const fs::path& file) { WriteCheckpoint(file, checkpoint); })};
}

Contents Examples() {
  GraspExamples examples;
  examples.success = {0, 1, 1};
  examples.image = {0, 0, 4};
  for (int i = 0; i < 3 * grasp::kSuccessInputs; ++i) {
    examples.inputs.push_back(0.01f * static_cast<float>(i));
  }
  return {
      BytesOfFile(kModel, [&](const fs::path& file) { SaveGraspExamples(file, kKey, examples); })};
}

template <typename Read>
FuzzTarget ModelTarget(const std::string& name, Contents (*seeds)(), Read read) {
  const auto run = [read](const fs::path& folder, const std::string& bytes) {
    const fs::path file = folder / kModel;
    WriteFileAtomically(file, WithRightHash(bytes));
    read(file);
  };
  return {name, run, seeds};
}

}  // namespace

std::vector<FuzzTarget> ModelTargets() {
  return {
      ModelTarget(
          "model", [] { return ModelAsset("shipped.net"); },
          [](const fs::path& file) { LoadModel(file); }),
      ModelTarget(
          "verifiers", [] { return ModelAsset("ppf.net"); },
          [](const fs::path& file) { LoadVerifiers(file, "ppf"); }),
      ModelTarget("shared_verifier", SharedVerifiers,
                  [](const fs::path& file) { LoadSharedVerifier(file); }),
      ModelTarget("completion_model", SmallCompletionModels,
                  [](const fs::path& file) { LoadCompletionModel(file); }),
      ModelTarget(
          "success_network", [] { return ModelAsset("grasps.net"); },
          [](const fs::path& file) { LoadSuccessNetwork(file); }),
      ModelTarget("checkpoint", Checkpoints,
                  [](const fs::path& file) { ReadCheckpoint(file, kKey); }),
      ModelTarget("grasp_examples", Examples,
                  [](const fs::path& file) { LoadGraspExamples(file, kKey); }),
  };
}

}  // namespace pickbed::tests
