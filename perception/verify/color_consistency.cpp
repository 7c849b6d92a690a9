#include "perception/verify/color_consistency.h"

#include <algorithm>
#include <optional>

#include "perception/model/model_points.h"
#include "scenes/base/math.h"

namespace pickbed::perception {
namespace {

// Upper median. Reorders the values.
double Median(std::vector<double>& values) {
  const auto median = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

// Median shares of red and green in the channel sum, over the pixels that show the object. Returns
// nothing if these pixels are too few or too dark.
std::optional<Eigen::Vector2d> ChromaticityAt(const OrganizedCloud& cloud, const ModelPoints& model,
                                              const Pose& X_CO) {
  constexpr int kDark = 60;  // sum of the channels
  constexpr size_t kMinPixels = 20;
  std::vector<double> red, green;
  for (const auto& [point, pixel] : SeenPoints(cloud, model, X_CO)) {
    const Rgb8& color = cloud.color.data()[pixel];
    const int sum = color.r + color.g + color.b;
    if (sum < kDark) continue;
    red.push_back(1.0 * color.r / sum);
    green.push_back(1.0 * color.g / sum);
  }
  if (red.size() < kMinPixels) return {};
  return Eigen::Vector2d(Median(red), Median(green));
}

std::optional<Eigen::Vector2d> ChromaticityOf(const OrganizedCloud& cloud,
                                              const std::vector<ModelPoints>& models,
                                              const PoseHypothesis& h) {
  const ModelPoints& model = models[h.object];
  if (!model.texture.colors.empty()) return {};
  return ChromaticityAt(cloud, model, h.X_CO);
}

}  // namespace

// Returns nothing if too few hypotheses are more likely right than wrong.
std::optional<CommonColors::CommonColor> CommonColors::Estimate(
    std::span<const PoseHypothesis> accepted, ObjectId object) const {
  constexpr size_t kMinPoses = 5;
  constexpr double kMinSpread = 0.01;  // effect of light reflected by neighbours
  std::vector<Eigen::Vector2d> all;
  for (const PoseHypothesis& h : accepted) {
    if (h.object != object || h.score < 0.5) continue;
    if (const auto chromaticity = ChromaticityOf(cloud_, models_, h)) all.push_back(*chromaticity);
  }
  if (all.size() < kMinPoses) return {};
  std::vector<double> red, green, distances;
  for (const Eigen::Vector2d& one : all) {
    red.push_back(one.x());
    green.push_back(one.y());
  }
  const Eigen::Vector2d center(Median(red), Median(green));
  for (const Eigen::Vector2d& one : all) distances.push_back((one - center).norm());
  return CommonColor{center, std::max(kMinSpread, Median(distances))};
}

CommonColors::CommonColors(const OrganizedCloud& cloud, const std::vector<ModelPoints>& models,
                           std::span<const PoseHypothesis> accepted)
    : cloud_(cloud), models_(models), by_object_(models.size()) {
  if (cloud.color.empty()) return;
  for (size_t object = 0; object < models.size(); ++object) {
    by_object_[object] = Estimate(accepted, ObjectId(object));
  }
}

bool CommonColors::LowerIfOdd(PoseHypothesis& hypothesis) const {
  // In spreads: no evidence up to kCommon, full evidence from kOdd.
  constexpr double kCommon = 4, kOdd = 8;
  constexpr double kAgainst = 5;  // nats against a pose at full evidence
  const std::optional<CommonColor>& common = by_object_[hypothesis.object];
  if (!common) return false;
  const auto chromaticity = ChromaticityOf(cloud_, models_, hypothesis);
  if (!chromaticity) return false;
  const double distance = (*chromaticity - common->center).norm() / common->spread;
  if (distance <= kCommon) return false;
  const double odd = std::min(1.0, (distance - kCommon) / (kOdd - kCommon));
  hypothesis.score = LessLikely(hypothesis.score, kAgainst * odd);
  return true;
}

}  // namespace pickbed::perception
