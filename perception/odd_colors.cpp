#include "perception/odd_colors.h"

#include <algorithm>
#include <optional>

#include "perception/seen_points.h"
#include "scenes/logistic.h"

namespace pickbed {
namespace {

// The upper one of two in the middle.
double Median(std::vector<double>& values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Shares of red and green in the light of the pixels that show a part, medians over them; nothing
// where few do or they are too dark to tell.
std::optional<Eigen::Vector2d> ChromaticityAt(const OrganizedCloud& cloud, const ModelPoints& model,
                                              const Pose& X_CO) {
  constexpr int kDark = 60;  // sum of the channels
  constexpr size_t kLeastPixels = 20;
  std::vector<double> red, green;
  for (const auto& [point, pixel] : SeenPoints(cloud, model, X_CO)) {
    const Rgb8& color = cloud.color.data()[pixel];
    const int sum = color.r + color.g + color.b;
    if (sum < kDark) continue;
    red.push_back(1.0 * color.r / sum);
    green.push_back(1.0 * color.g / sum);
  }
  if (red.size() < kLeastPixels) return {};
  return Eigen::Vector2d(Median(red), Median(green));
}

std::optional<Eigen::Vector2d> ChromaticityOf(const OrganizedCloud& cloud,
                                              const std::vector<ModelPoints>& models,
                                              const PoseHypothesis& h) {
  const ModelPoints& model = models[h.object];
  if (!model.print.colors.empty()) return {};
  return ChromaticityAt(cloud, model, h.X_CO);
}

// What is common in a kind.
struct CommonColor {
  Eigen::Vector2d middle;
  double spread = 0;
};

// Nothing where too few are rather right than not.
std::optional<CommonColor> CommonColorOf(const OrganizedCloud& cloud,
                                         const std::vector<ModelPoints>& models,
                                         std::span<const PoseHypothesis> accepted, int object) {
  constexpr size_t kLeastPoses = 5;
  constexpr double kLeastSpread = 0.01;  // what light from neighbours does
  std::vector<Eigen::Vector2d> all;
  for (const PoseHypothesis& h : accepted) {
    if (h.object != object || h.score < 0.5) continue;
    if (const auto chromaticity = ChromaticityOf(cloud, models, h)) all.push_back(*chromaticity);
  }
  if (all.size() < kLeastPoses) return {};
  std::vector<double> red, green, distances;
  for (const Eigen::Vector2d& one : all) {
    red.push_back(one.x());
    green.push_back(one.y());
  }
  const Eigen::Vector2d middle(Median(red), Median(green));
  for (const Eigen::Vector2d& one : all) distances.push_back((one - middle).norm());
  return CommonColor{middle, std::max(kLeastSpread, Median(distances))};
}

}  // namespace

bool LowerOddColors(const OrganizedCloud& cloud, const std::vector<ModelPoints>& models,
                    std::span<const PoseHypothesis> accepted,
                    std::span<PoseHypothesis> hypotheses) {
  constexpr double kCommon = 4, kOdd = 8;  // of the spread: up to there, and from there on
  constexpr double kAgainst = 5;           // nats that an odd colour speaks against a pose
  if (cloud.color.empty()) return false;
  std::vector<std::optional<CommonColor>> common;
  for (size_t object = 0; object < models.size(); ++object) {
    common.push_back(CommonColorOf(cloud, models, accepted, static_cast<int>(object)));
  }
  bool any = false;
  for (PoseHypothesis& h : hypotheses) {
    if (!common[h.object]) continue;
    const auto chromaticity = ChromaticityOf(cloud, models, h);
    if (!chromaticity) continue;
    const auto& [middle, spread] = *common[h.object];
    const double distance = (*chromaticity - middle).norm() / spread;
    if (distance <= kCommon) continue;
    const double odd = std::min(1.0, (distance - kCommon) / (kOdd - kCommon));
    h.score = LessLikely(h.score, kAgainst * odd);
    any = true;
  }
  return any;
}

}  // namespace pickbed
