#include "perception/odd_colors.h"

#include <algorithm>
#include <map>
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

struct Colored {
  int hypothesis = 0;
  Eigen::Vector2d chromaticity;
};

// Distance of each from the middle of those that are rather right than not, in units of their
// spread; empty where there are too few.
std::vector<double> Oddness(const std::vector<Colored>& colored,
                            const std::vector<PoseHypothesis>& hypotheses) {
  constexpr size_t kLeastPoses = 5;
  constexpr double kLeastSpread = 0.01;  // what light from neighbours does
  std::vector<double> red, green, distances;
  for (const auto& [i, chromaticity] : colored) {
    if (hypotheses[i].score < 0.5) continue;
    red.push_back(chromaticity.x());
    green.push_back(chromaticity.y());
  }
  if (red.size() < kLeastPoses) return {};
  const Eigen::Vector2d middle(Median(red), Median(green));
  for (const auto& [i, chromaticity] : colored) {
    if (hypotheses[i].score >= 0.5) distances.push_back((chromaticity - middle).norm());
  }
  const double spread = std::max(kLeastSpread, Median(distances));
  std::vector<double> oddness;
  for (const Colored& one : colored) {
    oddness.push_back((one.chromaticity - middle).norm() / spread);
  }
  return oddness;
}

}  // namespace

void LowerOddColors(const OrganizedCloud& cloud, const std::vector<ModelPoints>& models,
                    std::vector<PoseHypothesis>& hypotheses) {
  constexpr double kCommon = 4, kOdd = 8;  // of the spread: up to there, and from there on
  constexpr double kAgainst = 5;           // nats that an odd colour speaks against a pose
  if (cloud.color.empty()) return;
  std::map<int, std::vector<Colored>> by_object;
  for (size_t i = 0; i < hypotheses.size(); ++i) {
    const PoseHypothesis& h = hypotheses[i];
    const ModelPoints& model = models[h.object];
    if (!model.print.colors.empty()) continue;
    const auto chromaticity = ChromaticityAt(cloud, model, h.X_CO);
    if (chromaticity) by_object[h.object].push_back({static_cast<int>(i), *chromaticity});
  }
  for (const auto& [object, colored] : by_object) {
    const std::vector<double> oddness = Oddness(colored, hypotheses);
    for (size_t i = 0; i < oddness.size(); ++i) {
      const double odd = std::clamp((oddness[i] - kCommon) / (kOdd - kCommon), 0.0, 1.0);
      double& score = hypotheses[colored[i].hypothesis].score;
      if (odd > 0) score = LessLikely(score, kAgainst * odd);
    }
  }
  std::ranges::stable_sort(hypotheses, std::greater<>(), &PoseHypothesis::score);
}

}  // namespace pickbed
