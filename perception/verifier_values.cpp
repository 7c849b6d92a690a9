#include "perception/verifier_values.h"

#include "scenes/check.h"

namespace pickbed {
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
  // 2 * inputs, then hidden * (inputs + 2), then b2 and the calibrations.
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

}  // namespace pickbed
