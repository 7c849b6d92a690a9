#include "grasp/completed/success_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/math.h"
#include "scenes/scenario/planner_spec.h"

namespace pickbed::grasp {
namespace {

// The blocks are the training, means, scales, the outputs of each layer, and all weights.
constexpr std::string_view kMagic = "PICKGRSP";
constexpr uint64_t kVersion = 1;
constexpr int32_t kMaxOutputs = 4096;  // of a layer
// No network has weights near this. One of them would outvote all others.
constexpr float kLargestWeight = 1e4f;
constexpr double kFullWidth_m = 0.012;  // thickness from which a completed shape is not thin

Eigen::VectorXf ToVector(const std::vector<float>& values) {
  return Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Eigen::Index>(values.size()));
}

template <typename Matrix>
void Append(const Matrix& matrix, std::vector<float>& values) {
  values.insert(values.end(), matrix.data(), matrix.data() + matrix.size());
}

SuccessNetwork Parse(std::string_view bytes) {
  BlockReader reader(bytes, kMagic, kVersion, "a network for grasps");
  SuccessNetwork network;
  network.training = reader.Take();
  network.mean = ToVector(reader.TakeAll<float>());
  network.scale = ToVector(reader.TakeAll<float>());
  CheckInput(network.mean.size() == kSuccessInputs && network.scale.size() == kSuccessInputs,
             fmt::format("the network has {} inputs, but this version gives {}",
                         network.mean.size(), kSuccessInputs));
  CheckInput(
      network.mean.allFinite() && network.scale.allFinite() && (network.scale.array() > 0).all(),
      "a mean or a scale of the inputs is not finite, or a scale is not positive");
  const std::vector<int32_t> outputs = reader.TakeAll<int32_t>();
  const std::vector<float> weights = reader.TakeAll<float>();
  reader.RequireEnd();
  CheckInput(!outputs.empty() && outputs.back() == 1, "the last layer does not have one output");
  int64_t inputs = kSuccessInputs, used = 0;
  for (const int32_t count : outputs) {
    CheckInput(count >= 1 && count <= kMaxOutputs,
               fmt::format("a layer has {} outputs, but must have 1 to {}", count, kMaxOutputs));
    const int64_t size = count * (inputs + 1);
    CheckInput(used + size <= static_cast<int64_t>(weights.size()),
               "the file is damaged: weights are missing");
    PerceptronLayer& layer = network.layers.emplace_back();
    layer.weights = Eigen::Map<const Eigen::MatrixXf>(weights.data() + used, count, inputs);
    layer.bias = Eigen::Map<const Eigen::VectorXf>(weights.data() + used + count * inputs, count);
    const auto is_usual = [](float weight) { return std::abs(weight) <= kLargestWeight; };
    CheckInput(std::all_of(weights.begin() + used, weights.begin() + used + size, is_usual),
               fmt::format("a weight is not finite, or over {:g}", kLargestWeight));
    used += size;
    inputs = count;
  }
  CheckInput(used == static_cast<int64_t>(weights.size()),
             "the file is damaged: it has more weights than its layers");
  return network;
}

}  // namespace

std::vector<float> SuccessInputs(const GraspMeasures& measures, double opening_m, double tilt_rad,
                                 std::span<const float> surroundings) {
  constexpr double kMinScore = 1e-3;  // the logarithm of 0 is not finite
  constexpr double kMaxHidden_m = 0.02;
  const bool is_observed = measures.surface == GraspedSurface::kObserved;
  const double thin = is_observed ? 0 : std::max(0.0, 1 - measures.width_m / kFullWidth_m);
  const double log_score = is_observed ? std::log(std::max(measures.score, kMinScore)) : 0;
  const double values[kGraspMeasureInputs] = {is_observed ? 1.0 : 0.0,
                                              log_score,
                                              20 * measures.width_m,
                                              20 * opening_m,
                                              50 * std::min(measures.hidden_m, kMaxHidden_m),
                                              2 * measures.covered,
                                              30 * measures.center_offset_m,
                                              tilt_rad,
                                              thin};
  std::vector<float> inputs;
  inputs.reserve(kSuccessInputs);
  for (const double value : values) inputs.push_back(static_cast<float>(value));
  inputs.insert(inputs.end(), surroundings.begin(), surroundings.end());
  return inputs;
}

double SuccessNetwork::Chance(std::span<const float> inputs) const {
  const Eigen::Map<const Eigen::VectorXf> raw(inputs.data(),
                                              static_cast<Eigen::Index>(inputs.size()));
  Eigen::VectorXf values =
      ((raw - mean).array() / scale.array()).max(-kMaxInput).min(kMaxInput).matrix();
  for (size_t i = 0; i < layers.size(); ++i) {
    values = layers[i].weights * values + layers[i].bias;
    if (i + 1 < layers.size()) values = values.cwiseMax(0.0f);
  }
  return Logistic(values(0));
}

void SaveSuccessNetwork(const std::filesystem::path& file, const SuccessNetwork& network) {
  std::vector<int32_t> outputs;
  std::vector<float> mean, scale, weights;
  Append(network.mean, mean);
  Append(network.scale, scale);
  for (const PerceptronLayer& layer : network.layers) {
    outputs.push_back(static_cast<int32_t>(layer.bias.size()));
    Append(layer.weights, weights);
    Append(layer.bias, weights);
  }
  BlockWriter writer;
  writer.Put(network.training);
  writer.Put(mean);
  writer.Put(scale);
  writer.Put(outputs);
  writer.Put(weights);
  WriteFileAtomically(file, writer.Bytes(kMagic, kVersion));
}

SuccessNetwork LoadSuccessNetwork(const std::filesystem::path& file) {
  CheckInput(std::filesystem::exists(file),
             fmt::format("{}: there is no such network for grasps; make it with `pickbed train "
                         "grasps`, or set planner.success_model to none",
                         file.string()));
  const std::string bytes = ReadFileBytes(file);
  try {
    return Parse(bytes);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: {}; use the pickbed that wrote it, or train another one with "
                    "`pickbed train grasps`",
                    file.string(), error.what()));
  }
}

std::shared_ptr<const SuccessNetwork> SuccessNetworkNamed(const std::string& name) {
  if (name == kNoSuccessModel) return nullptr;
  return std::make_shared<SuccessNetwork>(LoadSuccessNetwork(TrainedFile(name)));
}

}  // namespace pickbed::grasp
