#include "perception/networks/verifier_file.h"

#include <fmt/format.h>
#include <torch/serialize/archive.h>
#include <torch/types.h>

#include <sstream>

#include "perception/networks/torch_runtime.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

constexpr const char* kVerifierMagic = "pickbed verifiers";
constexpr int64_t kOldest = 1, kWithOutline = 3, kWithModes = 4, kWithSupport = 5;
constexpr int64_t kVersion = 5;  // increase it when the meaning of the file changes

std::string ObjectsText(std::vector<ModelObject> objects) {
  return WriteSettings([&](SettingsVisitor& v) {
    v.List(
        "objects", objects.size(), [](size_t) {},
        [&](size_t i, SettingsVisitor& item) { objects[i].Visit(item); },
        "objects for which the verifiers are trained");
  });
}

std::vector<ModelObject> ObjectsFrom(const std::string& text, const std::string& name) {
  std::vector<ModelObject> objects;
  ReadSettingsText(text, name, [&](SettingsVisitor& v) {
    v.List(
        "objects", objects.size(), [&](size_t size) { objects.resize(size); },
        [&](size_t i, SettingsVisitor& item) { objects[i].Visit(item); },
        "objects for which the verifiers are trained");
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

std::string ReadText(torch::serialize::InputArchive& archive, const char* key) {
  c10::IValue value;
  archive.read(key, value);
  CheckInput(value.isString(), "the file is damaged");
  return value.toStringRef();
}

VerifierFile ReadVerifierArchive(const std::string& bytes, const std::string& name) {
  torch::serialize::InputArchive archive;
  archive.load_from(bytes.data(), bytes.size());
  CheckInput(ReadText(archive, "magic") == kVerifierMagic, "it is not a file of verifiers");
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
  // A training that was stopped before the first object was finished leaves only the network.
  const bool has_verifiers = !content.objects.empty() || !values.empty();
  const VerifierLayout layout = version == kOldest       ? kWithoutSurroundings
                                : version < kWithOutline ? kWithoutOutline
                                : version < kWithModes   ? kOneCalibration
                                : version < kWithSupport ? kWithoutSupport
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
  archive.write("magic", c10::IValue(std::string(kVerifierMagic)));
  archive.write("version", c10::IValue(kVersion));
  archive.write("objects", c10::IValue(objects_text));
  archive.write("estimator", c10::IValue(content.estimator));
  archive.write("sensor", c10::IValue(content.sensor));
  archive.write("training", c10::IValue(content.training));
  archive.write("verifiers", TensorOf(values));
  if (!content.network.settings.empty()) {
    archive.write("network", c10::IValue(content.network.settings));
    archive.write("weights", TensorOf(content.network.weights));
  }
  archive.write("hash", c10::IValue(static_cast<int64_t>(HashOf(texts, values, content.network))));
  std::ostringstream stream;
  archive.save_to(stream);
  WriteFileAtomically(file, stream.str());
}

VerifierFile LoadVerifiers(const std::filesystem::path& file, const std::string& estimator) {
  const auto fail = [&](const std::string& reason) {
    return InputError(fmt::format("{}: {}; make it with `pickbed train` as verifiers of {}",
                                  file.string(), reason, estimator));
  };
  if (!std::filesystem::exists(file)) throw fail("the verifier file does not exist");
  const std::string bytes = ReadFileBytes(file);
  VerifierFile content;
  try {
    content = ReadVerifierArchive(bytes, file.string());
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

namespace {

void AppendVerifier(const Verifier& verifier, std::vector<float>& values) {
  const auto append = [&](const auto& matrix) {
    values.insert(values.end(), matrix.data(), matrix.data() + matrix.size());
  };
  append(verifier.mean);
  append(verifier.scale);
  append(verifier.w1);
  append(verifier.b1);
  append(verifier.w2);
  values.push_back(verifier.b2);
  for (const Calibration& calibration : verifier.calibrations) {
    values.insert(values.end(), {calibration.scale, calibration.shift});
  }
}

}  // namespace

std::vector<float> VerifierValues(const std::vector<Verifier>& verifiers) {
  std::vector<float> values;
  for (const Verifier& verifier : verifiers) AppendVerifier(verifier, values);
  return values;
}

std::vector<Verifier> VerifiersFrom(const std::vector<float>& values, size_t count,
                                    const VerifierLayout& layout) {
  const int features = layout.features;
  CheckInput(count > 0 && values.size() % count == 0, "its verifiers have another shape");
  // Layout: 2 * features, hidden * (features + 2), b2, calibrations.
  const Eigen::Index scalars = 1 + 2 * layout.calibrations;
  const auto rest = static_cast<int64_t>(values.size() / count) - 2 * features - scalars;
  CheckInput(rest > 0 && rest % (features + 2) == 0, "its verifiers have another shape");
  const Eigen::Index hidden = rest / (features + 2);
  const float* next = values.data();
  const auto vector = [&](Eigen::Index size) {
    const Eigen::VectorXf result = Eigen::Map<const Eigen::VectorXf>(next, size);
    next += size;
    return result;
  };
  std::vector<Verifier> verifiers(count);
  for (Verifier& verifier : verifiers) {
    verifier.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
    verifier.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
    verifier.w1 = Eigen::MatrixXf::Zero(hidden, kVerifyFeatures);
    verifier.mean.head(features) = vector(features);
    verifier.scale.head(features) = vector(features);
    verifier.w1.leftCols(features) = vector(hidden * features).reshaped(hidden, features);
    verifier.b1 = vector(hidden);
    verifier.w2 = vector(hidden);
    verifier.b2 = *next++;
    for (int mode = 0; mode < layout.calibrations; ++mode, next += 2) {
      verifier.calibrations[mode] = {next[0], next[1]};
    }
    for (int mode = layout.calibrations; mode < kCandidateModes; ++mode) {
      verifier.calibrations[mode] = verifier.calibrations[0];
    }
  }
  return verifiers;
}

}  // namespace pickbed::perception
