#include "perception/networks/model_file.h"

#include <fmt/format.h>
#include <torch/serialize/archive.h>
#include <torch/types.h>

#include <sstream>

#include "perception/features/patch.h"
#include "perception/networks/torch_runtime.h"
#include "perception/networks/verifier_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/mesh_io/mesh_join.h"

namespace pickbed::perception {
namespace {

// Increase it when the meaning of the file changes; older programs then reject the file.
constexpr int64_t kModelVersion = 9;
// Version 3 has no recall. Versions 3 and 4 have only one kind of network.
constexpr int64_t kOldestVersion = 3;
constexpr const char* kModelMagic = "pickbed descriptor model";

std::vector<float> ToValues(const at::Tensor& tensor) {
  const at::Tensor values = tensor.to(torch::kFloat).contiguous();
  return {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()};
}

uint64_t HashValues(const std::vector<float>& weights, const std::vector<float>& verifier) {
  const uint64_t hash = HashBytes(weights.data(), weights.size() * sizeof(float));
  return HashBytes(verifier.data(), verifier.size() * sizeof(float), hash);
}

// Takes a copy, because Visit() is not const: it both reads and writes.
std::string InfoText(ModelInfo info) {
  return WriteSettings([&](SettingsVisitor& v) { info.Visit(v); });
}

DescriptorModel ReadModelArchive(const std::string& bytes, const std::string& name) {
  torch::serialize::InputArchive archive;
  archive.load_from(bytes.data(), bytes.size());
  c10::IValue value;
  archive.read("magic", value);
  CheckInput(value.isString() && value.toStringRef() == kModelMagic,
             "it is not a descriptor model");
  archive.read("version", value);
  const int64_t version = value.toInt();
  CheckInput(version <= kModelVersion,
             fmt::format("it is of version {}, newer than this program, which reads up to {}",
                         version, kModelVersion));
  CheckInput(version >= kOldestVersion,
             fmt::format("it is of version {}, older than {}", version, kOldestVersion));
  archive.read("info", value);
  const std::string info_text = value.toStringRef();
  at::Tensor weights, verifier;
  archive.read("weights", weights);
  archive.read("verifier", verifier);
  archive.read("training", value);
  const std::string training_text = value.toStringRef();
  archive.read("hash", value);
  const std::vector<float> weight_values = ToValues(weights), verifier_values = ToValues(verifier);
  const uint64_t hash = HashValues(weight_values, verifier_values);
  CheckInput(
      static_cast<uint64_t>(value.toInt()) == HashBytes(info_text.data(), info_text.size(), hash),
      "its check sum is wrong");
  ModelInfo info;
  info.training = training_text;
  ReadSettingsText(info_text, name, [&](SettingsVisitor& v) { info.Visit(v); });
  DescriptorNetwork network(info.network, 0, static_cast<int>(info.objects.size()));
  network.SetWeights(weight_values);
  const uint64_t network_hash =
      HashBytes(weight_values.data(), weight_values.size() * sizeof(float));
  constexpr int64_t kWithSurroundings = 6, kWithOutline = 7, kWithModes = 8, kWithSupport = 9;
  const VerifierLayout layout = version < kWithSurroundings ? kWithoutSurroundings
                                : version < kWithOutline    ? kWithoutOutline
                                : version < kWithModes      ? kOneCalibration
                                : version < kWithSupport    ? kWithoutSupport
                                                            : VerifierLayout();
  std::vector<Verifier> verifiers = VerifiersFrom(verifier_values, info.objects.size(), layout);
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
  const std::string text = InfoText(info);
  const uint64_t hash = HashBytes(text.data(), text.size(), HashValues(weights, verifier));
  torch::serialize::OutputArchive archive;
  archive.write("magic", c10::IValue(std::string(kModelMagic)));
  archive.write("version", c10::IValue(kModelVersion));
  archive.write("info", c10::IValue(text));
  archive.write("training", c10::IValue(info.training));
  archive.write("weights", TensorOf(weights));
  archive.write("verifier", TensorOf(verifier));
  archive.write("hash", c10::IValue(static_cast<int64_t>(hash)));
  std::ostringstream stream;
  archive.save_to(stream);
  WriteFileAtomically(file, stream.str());
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
    return ReadModelArchive(bytes, file.string());
  } catch (const InputError& error) {
    throw fail(error.what());
  } catch (const c10::Error&) {
    throw fail("the file is damaged or is not a model");
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

// Returns whether a coloured object has the shape of an object that was trained without colours.
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

std::filesystem::path TrainedFile(const std::string& name) {
  const std::filesystem::path path = name;
  if (path.has_parent_path()) return path;
  if (path.extension() == ".pt" && std::filesystem::exists(path)) return path;
  return AssetsDir() / "models" / (path.extension() == ".pt" ? name : name + ".pt");
}

}  // namespace pickbed::perception
