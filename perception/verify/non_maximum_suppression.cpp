#include "perception/verify/non_maximum_suppression.h"

#include <fmt/format.h>

#include <algorithm>

#include "perception/cloud/projector.h"
#include "perception/verify/physical_consistency.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Writes the foreground pixels near the model surface into `pixels`.
void FindClaims(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                const NonMaximumSuppressionOptions& options, std::vector<int>& pixels) {
  pixels.clear();
  const Eigen::Isometry3f X_OC = X_CO.inverse(Eigen::Isometry).cast<float>();
  const Eigen::Vector3f center_C = (X_CO * model.center_O.cast<double>()).cast<float>();
  const float claim_m = static_cast<float>(options.claim_m);
  const float reach_m = model.radius_m + claim_m;
  const PixelBox box = BallPixels(cloud.intrinsics, center_C, reach_m);
  const int stride = options.pixel_stride;
  // Multiples of the stride, so that all hypotheses use the same pixels.
  const auto first = [&](int low) { return (low + stride - 1) / stride * stride; };
  for (int y = first(box.y0); y < box.y1; y += stride) {
    for (int x = first(box.x0); x < box.x1; x += stride) {
      if (!cloud.foreground(x, y)) continue;
      const int pixel = y * cloud.intrinsics.width() + x;
      const Eigen::Vector3f& q = cloud.points_C[pixel];
      if ((q - center_C).squaredNorm() > reach_m * reach_m) continue;
      if (model.distance.At(X_OC * q) <= claim_m) pixels.push_back(pixel);
    }
  }
}

// Returns the first kept hypothesis that h penetrates too deeply; null = none.
PoseHypothesis* LiesIn(const std::vector<ModelPoints>& models, const PoseHypothesis& h,
                       double max_share, std::vector<PoseHypothesis>& kept) {
  const ModelPoints& own = models.at(h.object);
  const auto found = std::find_if(kept.begin(), kept.end(), [&](const PoseHypothesis& better) {
    const ModelPoints& other = models.at(better.object);
    return PenetrationDepth(own, h.X_CO, other, better.X_CO) >
           max_share * std::min(own.diameter_m, other.diameter_m);
  });
  return found == kept.end() ? nullptr : &*found;
}

}  // namespace

void NonMaximumSuppressionOptions::Visit(SettingsVisitor& v) {
  v.Real("claim_m", claim_m, {0, 1}, "distance to the model surface of a claimed pixel, m");
  v.Real("max_shared_share", max_shared_share, {0, 1},
         "maximum share of a hypothesis's pixels that better ones claim");
  v.Integer("pixel_stride", pixel_stride, {1, 1000}, "rows and columns per evaluated one");
  v.Real("max_penetration_share", max_penetration_share, {0, 10},
         "maximum penetration over the smaller diameter");
}

std::vector<PoseHypothesis> SuppressNonMaxima(const OrganizedCloud& cloud,
                                              const std::vector<ModelPoints>& models,
                                              std::vector<PoseHypothesis> hypotheses,
                                              const NonMaximumSuppressionOptions& options,
                                              std::span<const int> instances) {
  CheckSettings("NonMaximumSuppressionOptions", options);
  CheckInput(instances.empty() || instances.size() == models.size(),
             fmt::format("the number of instances is given for {} objects, but {} objects are "
                         "searched; give it for each",
                         instances.size(), models.size()));
  std::stable_sort(
      hypotheses.begin(), hypotheses.end(),
      [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
  Image<uint16_t> claimed_by(cloud.intrinsics.width(),
                             cloud.intrinsics.height());  // kept index + 1
  std::vector<PoseHypothesis> kept;
  std::vector<int> pixels, shared_with;
  const auto all_found = [&](ObjectId object) {
    return !instances.empty() &&
           std::ranges::count(kept, object, &PoseHypothesis::object) >= instances[object];
  };
  for (PoseHypothesis& h : hypotheses) {
    if (all_found(h.object)) continue;
    FindClaims(cloud, models.at(h.object), h.X_CO, options, pixels);
    if (pixels.empty()) continue;
    shared_with.assign(kept.size() + 1, 0);  // [0]: claimed by none
    for (const int pixel : pixels) ++shared_with[claimed_by.data()[pixel]];
    const double shared = static_cast<double>(pixels.size()) - shared_with[0];
    PoseHypothesis* winner = nullptr;
    if (shared > options.max_shared_share * static_cast<double>(pixels.size())) {
      const auto largest = std::max_element(shared_with.begin() + 1, shared_with.end());
      winner = &kept[largest - shared_with.begin() - 1];
    } else {
      winner = LiesIn(models, h, options.max_penetration_share, kept);
    }
    if (winner) {
      if (winner->object == h.object) winner->suppressed_X_CO.push_back(h.X_CO);
      continue;
    }
    for (const int pixel : pixels) {
      if (claimed_by.data()[pixel] == 0) claimed_by.data()[pixel] = kept.size() + 1;
    }
    kept.push_back(std::move(h));
  }
  return kept;
}

}  // namespace pickbed::perception
