#include "perception/torch_verifier_file.h"

#include <fmt/format.h>
#include <torch/torch.h>

#include <sstream>

#include "perception/verifier_values.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/random.h"

namespace pickbed {
namespace {

constexpr const char* kMagic = "pickbed verifiers";
constexpr int64_t kOldest = 1, kWithOutline = 3, kWithModes = 4;
constexpr int64_t kVersion = 4;  // raise when the meaning of the file changes

std::string ObjectsText(std::vector<ModelObject> objects) {
  return WriteSettings([&](SettingsVisitor& v) {
    v.List(
        "objects", objects.size(), [](size_t) {},
        [&](size_t i, SettingsVisitor& item) { objects[i].Visit(item); }, "what it is trained for");
  });
}

std::vector<ModelObject> ObjectsFrom(const std::string& text, const std::string& name) {
  std::vector<ModelObject> objects;
  ReadSettingsText(text, name, [&](SettingsVisitor& v) {
    v.List(
        "objects", objects.size(), [&](size_t size) { objects.resize(size); },
        [&](size_t i, SettingsVisitor& item) { objects[i].Visit(item); }, "what it is trained for");
  });
  return objects;
}

uint64_t HashOf(const std::string& texts, const std::vector<float>& verifiers,
                const LearnedNetwork& network) {
  const auto add = [](const std::vector<float>& values, uint64_t hash) {
    return HashBytes(values.data(), values.size() * sizeof(float), hash);
  };
  const uint64_t hash = add(verifiers, HashBytes(texts.data(), texts.size()));
  if (network.settings.empty()) return hash;
  return add(network.weights, HashBytes(network.settings.data(), network.settings.size(), hash));
}

std::vector<float> ReadValues(torch::serialize::InputArchive& archive, const char* key) {
  at::Tensor tensor;
  archive.read(key, tensor);
  tensor = tensor.to(torch::kFloat).contiguous();
  return {tensor.data_ptr<float>(), tensor.data_ptr<float>() + tensor.numel()};
}

at::Tensor ToTensor(const std::vector<float>& values) {
  return torch::tensor(at::ArrayRef<float>(values), torch::kFloat);
}

std::string ReadText(torch::serialize::InputArchive& archive, const char* key) {
  c10::IValue value;
  archive.read(key, value);
  CheckInput(value.isString(), "the file is damaged");
  return value.toStringRef();
}

VerifierFile ReadArchive(const std::string& bytes, const std::string& name) {
  torch::serialize::InputArchive archive;
  archive.load_from(bytes.data(), bytes.size());
  CheckInput(ReadText(archive, "magic") == kMagic, "it holds no verifiers alone");
  c10::IValue value;
  archive.read("version", value);
  const int64_t version = value.toInt();
  CheckInput(version >= kOldest && version <= kVersion,
             fmt::format("it has version {}, this program reads up to {}", version, kVersion));
  const std::string objects_text = ReadText(archive, "objects");
  VerifierFile content;
  content.estimator = ReadText(archive, "estimator");
  content.sensor = ReadText(archive, "sensor");
  content.training = ReadText(archive, "training");
  const std::vector<float> values = ReadValues(archive, "verifiers");
  if (archive.try_read("network", value)) {
    content.network.settings = value.toStringRef();
    content.network.weights = ReadValues(archive, "weights");
  }
  archive.read("hash", value);
  const std::string texts = objects_text + content.estimator + content.sensor + content.training;
  CheckInput(static_cast<uint64_t>(value.toInt()) == HashOf(texts, values, content.network),
             "its check sum is wrong");
  content.objects = ObjectsFrom(objects_text, name);
  // Of a training that was stopped before the first part was done there is the network alone.
  const bool has_verifiers = !content.objects.empty() || !values.empty();
  const VerifierLayout layout = version == kOldest       ? kWithoutSurroundings
                                : version < kWithOutline ? kWithoutOutline
                                : version < kWithModes   ? kOneCalibration
                                                         : VerifierLayout();
  if (has_verifiers) {
    content.verifiers = VerifiersFrom(values, content.objects.size(), layout);
  }
  return content;
}

}  // namespace

void SaveVerifiers(const std::filesystem::path& file, const VerifierFile& content) {
  const std::vector<float> values = VerifierValues(content.verifiers);
  const std::string objects_text = ObjectsText(content.objects);
  const std::string texts = objects_text + content.estimator + content.sensor + content.training;
  torch::serialize::OutputArchive archive;
  archive.write("magic", c10::IValue(std::string(kMagic)));
  archive.write("version", c10::IValue(kVersion));
  archive.write("objects", c10::IValue(objects_text));
  archive.write("estimator", c10::IValue(content.estimator));
  archive.write("sensor", c10::IValue(content.sensor));
  archive.write("training", c10::IValue(content.training));
  archive.write("verifiers", ToTensor(values));
  if (!content.network.settings.empty()) {
    archive.write("network", c10::IValue(content.network.settings));
    archive.write("weights", ToTensor(content.network.weights));
  }
  archive.write("hash", c10::IValue(static_cast<int64_t>(HashOf(texts, values, content.network))));
  std::ostringstream stream;
  archive.save_to(stream);
  WriteFileAtomically(file, stream.str());
}

VerifierFile LoadVerifiers(const std::filesystem::path& file, const std::string& estimator) {
  const auto fail = [&](const std::string& reason) {
    return InputError(fmt::format("{}: {}; make it with `pickbed train PART... --verifier-for {}`",
                                  file.string(), reason, estimator));
  };
  if (!std::filesystem::exists(file)) throw fail("there is no such file of verifiers");
  const std::string bytes = ReadFileBytes(file);
  VerifierFile content;
  try {
    content = ReadArchive(bytes, file.string());
  } catch (const InputError& error) {
    throw fail(error.what());
  } catch (const c10::Error&) {
    throw fail("the file is damaged or holds no verifiers");
  }
  if (content.estimator != estimator) {
    throw fail(fmt::format("its verifiers are for '{}'", content.estimator));
  }
  return content;
}

}  // namespace pickbed
