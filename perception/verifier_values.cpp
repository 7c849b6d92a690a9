#include "perception/verifier_values.h"

#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr Eigen::Index kVerifierScalars = 3;  // b2 and the calibration

void AppendVerifier(const Verifier& verifier, std::vector<float>& values) {
  const auto append = [&](const auto& matrix) {
    values.insert(values.end(), matrix.data(), matrix.data() + matrix.size());
  };
  append(verifier.mean);
  append(verifier.scale);
  append(verifier.w1);
  append(verifier.b1);
  append(verifier.w2);
  values.insert(values.end(),
                {verifier.b2, verifier.calibration_scale, verifier.calibration_shift});
}

}  // namespace

std::vector<float> VerifierValues(const std::vector<Verifier>& verifiers) {
  std::vector<float> values;
  for (const Verifier& verifier : verifiers) AppendVerifier(verifier, values);
  return values;
}

std::vector<Verifier> VerifiersFrom(const std::vector<float>& values, size_t count, int features) {
  CheckInput(count > 0 && values.size() % count == 0, "its verifiers have another shape");
  // 2 * inputs, then hidden * (inputs + 2), then the scalars.
  const auto rest = static_cast<int64_t>(values.size() / count) - 2 * features - kVerifierScalars;
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
    const Eigen::VectorXf scalars = vector(kVerifierScalars);
    verifier.b2 = scalars[0];
    verifier.calibration_scale = scalars[1];
    verifier.calibration_shift = scalars[2];
  }
  return verifiers;
}

}  // namespace pickbed
