#include "perception/networks/model_file.h"

#include <fmt/format.h>

#include "perception/features/patch.h"
#include "perception/networks/tensor_file.h"
#include "perception/networks/verifier_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/mesh_io/mesh_join.h"

namespace pickbed::perception {
namespace {

// Increase it when the meaning of the file changes; older programs then reject the file.
constexpr int kModelVersion = 10;
// Version 3 has no recall. Versions 3 and 4 have only one kind of network.
constexpr int kOldestVersion = 3;
constexpr const char* kModelKind = "descriptor model";

uint64_t HashValues(const std::vector<float>& weights, const std::vector<float>& verifier) {
  const uint64_t hash = HashBytes(weights.data(), weights.size() * sizeof(float));
  return HashBytes(verifier.data(), verifier.size() * sizeof(float), hash);
}

// Takes a copy, because Visit() is not const: it both reads and writes.
std::string InfoText(ModelInfo info) {
  return WriteSettings([&](SettingsVisitor& v) { info.Visit(v); });
}

DescriptorModel ParseModel(const std::string& bytes, const std::string& name) {
  const TensorFile file = TensorFile::Parse(bytes, kModelKind, kOldestVersion, kModelVersion);
  const std::vector<float> weights = file.Floats("weights"), verifier = file.Floats("verifier");
  const uint64_t hash = HashValues(weights, verifier);
  const int version = file.version();
  ModelInfo info;
  info.training = file.Text("training");
  ReadSettingsText(file.Text("info"), name, [&](SettingsVisitor& v) { info.Visit(v); });
  DescriptorNetwork network(info.network, 0, static_cast<int>(info.objects.size()));
  network.SetWeights(weights);
  const uint64_t network_hash = HashBytes(weights.data(), weights.size() * sizeof(float));
  constexpr int kWithSurroundings = 6, kWithOutline = 7, kWithModes = 8, kWithSupport = 9,
                kWithUnknown = 10;
  const VerifierLayout layout = version < kWithSurroundings ? kWithoutSurroundings
                                : version < kWithOutline    ? kWithoutOutline
                                : version < kWithModes      ? kOneCalibration
                                : version < kWithSupport    ? kWithoutSupport
                                : version < kWithUnknown    ? kWithoutUnknown
                                                            : VerifierLayout();
  std::vector<Verifier> verifiers = VerifiersFrom(verifier, info.objects.size(), layout);
  return {info, std::move(network), std::move(verifiers), network_hash, hash};
}

}  // namespace

void ModelObject::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "name of the object");
  v.Seed("mesh_hash", mesh_hash, "hash of the object's mesh");
  v.Real("diameter_m", diameter_m, {0, 100}, "diameter of the object, m");
  v.Real("side_m", side_m, {0, 100}, "side of the object's patches, m");
  v.Real("verifier_auc", verifier_auc, {0, 1}, "area under the ROC curve on held-out poses");
  v.Real("recall_at_1", recall_at_1, {-1, 1}, "recall@1 on held-out patches, -1 = not measured");
  v.Real("recall_at_8", recall_at_8, {-1, 1}, "recall@8 on held-out patches, -1 = not measured");
}

void ModelInfo::Visit(SettingsVisitor& v) {
  v.List(
      "objects", objects.size(), [&](size_t size) { objects.resize(size); },
      [&](size_t i, SettingsVisitor& item) { objects[i].Visit(item); },
      "objects for which the model is trained");
  v.Text("sensor", sensor, {}, "sensor profile of the training views");
  v.Group(
      "network", [&](SettingsVisitor& g) { network.Visit(g); }, "settings of the network");
  v.Integer("iterations", iterations, {0, 1e9}, "number of training steps done");
  v.Real("loss", loss, {-1e9, 1e9}, "mean loss of the last hundred steps");
  v.Real("recall_at_1", recall_at_1, {-1, 1}, "recall@1 on held-out patches, -1 = not measured");
  v.Real("recall_at_8", recall_at_8, {-1, 1}, "recall@8 on held-out patches, -1 = not measured");
}

void SaveModel(const std::filesystem::path& file, const ModelInfo& info,
               const DescriptorNetwork& network, const std::vector<Verifier>& verifiers) {
  const std::vector<float> weights = network.Weights();
  const std::vector<float> verifier = VerifierValues(verifiers);
  TensorFile content(kModelKind, kModelVersion);
  content.PutText("info", InfoText(info));
  content.PutText("training", info.training);
  content.Put("weights", weights);
  const auto count = static_cast<int64_t>(verifiers.size());
  content.Put("verifier", verifier,
              {count, count ? static_cast<int64_t>(verifier.size()) / count : 0});
  WriteFileAtomically(file, content.Bytes());
}

DescriptorModel LoadModel(const std::filesystem::path& file, const std::string& command) {
  CheckInput(
      std::filesystem::exists(file),
      fmt::format("{}: there is no such trained model; make it with {}", file.string(), command));
  const std::string bytes = ReadFileBytes(file);
  const auto fail = [&](const std::string& reason) {
    return InputError(
        fmt::format("{}: {}; train it again with {}", file.string(), reason, command));
  };
  try {
    return ParseModel(bytes, file.string());
  } catch (const InputError& error) {
    throw fail(error.what());
  }
}

// Returns the command with the names of the objects: "`pickbed train kehl nut bolt`".
std::string CommandFor(const ObjectSet& objects, const std::string& command) {
  const size_t quote = command.rfind('`');
  if (quote == std::string::npos) return command;
  std::string names;
  for (const auto& object : objects) names += " " + object->name;
  return command.substr(0, quote) + names + command.substr(quote);
}

namespace {

// Returns whether a colored object has the shape of an object that was trained without colors.
bool IsSameShape(const ModelObject& trained, const ObjectModel& object) {
  const TriangleMesh& mesh_O = object.mesh_O;
  if (mesh_O.colors.empty() && mesh_O.uvs.empty()) return false;
  return std::ranges::count(UncoloredHashes(mesh_O), trained.mesh_hash) > 0;
}

}  // namespace

std::vector<int> TrainedObjects(const std::vector<ModelObject>& trained, const ObjectSet& objects,
                                const std::filesystem::path& file, const std::string& command) {
  std::vector<int> indices;
  for (const auto& object : objects) {
    const ModelObject* found = nullptr;
    std::string known;
    for (const ModelObject& trained_object : trained) {
      known += (known.empty() ? "" : ", ") + trained_object.name;
      if (trained_object.name == object->name) found = &trained_object;
    }
    CheckInput(found,
               fmt::format("{}: not trained for object '{}' (knows {}); train a model with {}",
                           file.string(), object->name, known, CommandFor(objects, command)));
    CheckInput(
        found->mesh_hash == object->mesh_hash || IsSameShape(*found, *object),
        fmt::format("{}: the mesh of object '{}' has changed since training; train again with {}",
                    file.string(), object->name, command));
    indices.push_back(static_cast<int>(found - trained.data()));
  }
  return indices;
}

}  // namespace pickbed::perception
