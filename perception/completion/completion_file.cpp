#include "perception/completion/completion_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

// The blocks are settings, weights and statistics.
constexpr std::string_view kMagic = "PICKCOMP";
constexpr uint64_t kVersion = 2;
constexpr uint64_t kOldestVersion = 2;  // older networks had no image

// The 16-bit float nearest to a value, ties to even (IEEE 754 binary16).
uint16_t ToHalf(float value) { return Eigen::numext::bit_cast<uint16_t>(Eigen::half(value)); }

float FromHalf(uint16_t bits) {
  return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits));
}

CompletionModel Parse(std::string_view bytes, const std::string& name, const std::string& device) {
  BlockReader reader(bytes, kMagic, kVersion, "a completion model", kOldestVersion);
  CompletionModelInfo info;
  const std::string text(reader.Take());
  ReadSettingsText(text, name, [&](SettingsVisitor& v) { info.Visit(v); });
  const std::vector<uint16_t> halves = reader.TakeAll<uint16_t>();
  const std::vector<float> statistics = reader.TakeAll<float>();
  reader.RequireEnd();
  std::vector<float> weights(halves.size());
  for (size_t i = 0; i < halves.size(); ++i) weights[i] = FromHalf(halves[i]);
  // The statistics are means and variances of activations, which are larger than weights.
  constexpr float kLargestWeight = 100, kLargestStatistic = 1e6f;
  const auto within = [](const std::vector<float>& values, float largest) {
    return std::ranges::all_of(values, [&](float v) { return std::abs(v) <= largest; });
  };
  CheckInput(
      within(weights, kLargestWeight) && within(statistics, kLargestStatistic),
      fmt::format("a weight is not finite or over {:g}, or a statistic is not finite or over "
                  "{:g}",
                  kLargestWeight, kLargestStatistic));
  CompletionNetwork network(info.network, 0, device);
  network.SetWeights(weights, statistics);
  return {info, std::move(network)};
}

}  // namespace

void CompletionModelInfo::Visit(SettingsVisitor& v) {
  v.Group(
      "network", [&](SettingsVisitor& g) { network.Visit(g); }, "settings of the network");
  v.Words("domains", domains, "shape domains of the training");
  v.Words("families", families, "shape families of the training");
  v.Words("sensors", sensors, "sensor profiles of the training views");
  v.Integer("steps", steps, {0, 1e9}, "number of training steps done");
  v.Real("loss", loss, {-1, 1e9}, "cross-entropy on held-out views, -1 = not measured");
  v.Real("iou", iou, {-1, 1}, "IoU on points of held-out views, -1 = not measured");
  v.Text("training", training, {}, "settings of the training");
}

void SaveCompletionModel(const std::filesystem::path& file, const CompletionModelInfo& info,
                         const CompletionNetwork& network) {
  CompletionModelInfo copy = info;  // Visit() is not const
  const std::string text = WriteSettings([&](SettingsVisitor& v) { copy.Visit(v); });
  std::vector<uint16_t> halves;
  for (const float weight : network.Weights()) {
    halves.push_back(ToHalf(weight));
    // A weight over 65504 is infinite as a 16-bit float.
    CheckInput(std::isfinite(FromHalf(halves.back())),
               fmt::format("{}: weight {} is no finite 16-bit float; train again with a smaller "
                           "learning_rate",
                           file.string(), weight));
  }
  BlockWriter writer;
  writer.Put(text);
  writer.Put(halves);
  writer.Put(network.Statistics());
  WriteFileAtomically(file, writer.Bytes(kMagic, kVersion));
}

CompletionModel LoadCompletionModel(const std::filesystem::path& file, const std::string& device) {
  CheckInput(std::filesystem::exists(file),
             fmt::format("{}: there is no such completion model; make it with `pickbed train "
                         "completion`",
                         file.string()));
  const std::string bytes = ReadFileBytes(file);
  try {
    return Parse(bytes, file.string(), device);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: {}; use the pickbed that wrote it, or train another one with `pickbed "
                    "train completion`",
                    file.string(), error.what()));
  }
}

}  // namespace pickbed::perception
