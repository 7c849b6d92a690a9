#include "perception/networks/verifier_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "perception/networks/tensor_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

constexpr const char* kKind = "file of verifiers";
constexpr int kOldest = 1, kWithOutline = 3, kWithModes = 4, kWithSupport = 5, kWithUnknown = 6;
constexpr int kVersion = 6;  // increase it when the meaning of the file changes

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

VerifierFile ParseVerifiers(const std::string& bytes, const std::string& name) {
  const TensorFile file = TensorFile::Parse(bytes, kKind, kOldest, kVersion);
  VerifierFile content;
  content.estimator = file.Text("estimator");
  content.sensor = file.Text("sensor");
  content.training = file.Text("training");
  const std::string objects_text = file.Text("objects");
  const std::vector<float> values = file.Floats("verifiers");
  if (file.Has("network")) {
    content.network.settings = file.Text("network");
    content.network.weights = file.Floats("weights");
  }
  const int version = file.version();
  content.objects = ObjectsFrom(objects_text, name);
  // A training that was stopped before the first object was finished leaves only the network.
  const bool has_verifiers = !content.objects.empty() || !values.empty();
  const VerifierLayout layout = version == kOldest       ? kWithoutSurroundings
                                : version < kWithOutline ? kWithoutOutline
                                : version < kWithModes   ? kOneCalibration
                                : version < kWithSupport ? kWithoutSupport
                                : version < kWithUnknown ? kWithoutUnknown
                                                         : VerifierLayout();
  if (has_verifiers) {
    content.verifiers = VerifiersFrom(values, content.objects.size(), layout);
  }
  return content;
}

}  // namespace

void SaveVerifiers(const std::filesystem::path& file, const VerifierFile& content) {
  const std::vector<float> values = VerifierValues(content.verifiers);
  TensorFile stored(kKind, kVersion);
  stored.PutText("objects", ObjectsText(content.objects));
  stored.PutText("estimator", content.estimator);
  stored.PutText("sensor", content.sensor);
  stored.PutText("training", content.training);
  stored.Put("verifiers", values);
  if (!content.network.settings.empty()) {
    stored.PutText("network", content.network.settings);
    stored.Put("weights", content.network.weights);
  }
  WriteFileAtomically(file, stored.Bytes());
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
    content = ParseVerifiers(bytes, file.string());
  } catch (const InputError& error) {
    throw fail(error.what());
  }
  if (content.estimator != estimator) {
    throw fail(fmt::format("its verifiers are for '{}'", content.estimator));
  }
  return content;
}

namespace {

void AppendNetwork(const VerifierNetwork& network, std::vector<float>& values) {
  const auto append = [&](const auto& matrix) {
    values.insert(values.end(), matrix.data(), matrix.data() + matrix.size());
  };
  append(network.mean);
  append(network.scale);
  append(network.w1);
  append(network.b1);
  append(network.w2);
  values.push_back(network.b2);
}

Eigen::Index UnitsOf(const std::vector<Verifier>& verifiers) {
  Eigen::Index units = 0;
  for (const Verifier& verifier : verifiers) {
    units = std::max({units, verifier.known.b1.size(), verifier.unknown.b1.size()});
  }
  return units;
}

// Adds hidden units without an effect.
VerifierNetwork WithUnits(VerifierNetwork network, Eigen::Index units) {
  const Eigen::Index added = units - network.b1.size();
  network.w1.conservativeResize(units, Eigen::NoChange);
  network.w1.bottomRows(added).setZero();
  network.b1.conservativeResize(units);
  network.b1.tail(added).setZero();
  network.w2.conservativeResize(units);
  network.w2.tail(added).setZero();
  return network;
}

void AppendVerifier(const Verifier& verifier, Eigen::Index units, std::vector<float>& values) {
  AppendNetwork(WithUnits(verifier.known, units), values);
  AppendNetwork(WithUnits(verifier.unknown, units), values);
  for (const auto& by_mode : verifier.calibrations) {
    for (const Calibration& calibration : by_mode) {
      values.insert(values.end(), {calibration.scale, calibration.shift});
    }
  }
}

// Reads a network and moves `next` behind it.
VerifierNetwork NetworkFrom(const float*& next, int features, Eigen::Index hidden) {
  const auto vector = [&](Eigen::Index size) {
    const Eigen::VectorXf result = Eigen::Map<const Eigen::VectorXf>(next, size);
    next += size;
    return result;
  };
  VerifierNetwork network;
  network.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
  network.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  network.w1 = Eigen::MatrixXf::Zero(hidden, kVerifyFeatures);
  network.mean.head(features) = vector(features);
  network.scale.head(features) = vector(features);
  network.w1.leftCols(features) = vector(hidden * features).reshaped(hidden, features);
  network.b1 = vector(hidden);
  network.w2 = vector(hidden);
  network.b2 = *next++;
  return network;
}

}  // namespace

std::vector<float> VerifierValues(const std::vector<Verifier>& verifiers) {
  std::vector<float> values;
  const Eigen::Index units = UnitsOf(verifiers);
  for (const Verifier& verifier : verifiers) AppendVerifier(verifier, units, values);
  return values;
}

std::vector<Verifier> VerifiersFrom(const std::vector<float>& values, size_t count,
                                    const VerifierLayout& layout) {
  const int features = layout.features;
  CheckInput(count > 0 && values.size() % count == 0, "its verifiers have another shape");
  // Layout: per network 2 * features, hidden * (features + 2), b2; then the calibrations.
  const int networks = layout.has_unknown ? 2 : 1;
  const int kinds = layout.has_unknown ? kBackgroundKinds : 1;
  const Eigen::Index scalars =
      static_cast<Eigen::Index>(networks) * (2 * features + 1) + 2 * kinds * layout.calibrations;
  const auto rest = static_cast<int64_t>(values.size() / count) - scalars;
  const int64_t per_unit = static_cast<int64_t>(networks) * (features + 2);
  CheckInput(rest > 0 && rest % per_unit == 0, "its verifiers have another shape");
  const Eigen::Index hidden = rest / per_unit;
  const float* next = values.data();
  std::vector<Verifier> verifiers(count);
  for (Verifier& verifier : verifiers) {
    verifier.known = NetworkFrom(next, features, hidden);
    verifier.unknown = layout.has_unknown ? NetworkFrom(next, features, hidden) : verifier.known;
    for (int kind = 0; kind < kinds; ++kind) {
      auto& by_mode = verifier.calibrations[kind];
      for (int mode = 0; mode < layout.calibrations; ++mode, next += 2) {
        by_mode[mode] = {next[0], next[1]};
      }
      for (int mode = layout.calibrations; mode < kCandidateModes; ++mode) {
        by_mode[mode] = by_mode[0];
      }
    }
    for (int kind = kinds; kind < kBackgroundKinds; ++kind) {
      verifier.calibrations[kind] = verifier.calibrations[0];
    }
  }
  return verifiers;
}

}  // namespace pickbed::perception
