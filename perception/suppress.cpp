#include "perception/suppress.h"

#include <algorithm>

#include "perception/projector.h"

namespace pickbed {
namespace {

// Foreground pixels near the model's surface, written into `pixels`.
void FindClaims(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                const SuppressOptions& options, std::vector<int>& pixels) {
  pixels.clear();
  const Eigen::Isometry3f X_OC = X_CO.inverse(Eigen::Isometry).cast<float>();
  const Eigen::Vector3f center_C = (X_CO * model.center_O.cast<double>()).cast<float>();
  const float claim_m = static_cast<float>(options.claim_m);
  const float reach_m = model.radius_m + claim_m;
  const PixelBox box = BallPixels(cloud.intrinsics, center_C, reach_m);
  const int stride = std::max(1, options.pixel_stride);
  // Multiples of the stride, so that all hypotheses look at the same pixels.
  const auto first = [&](int low) { return (low + stride - 1) / stride * stride; };
  for (int y = first(box.y0); y < box.y1; y += stride) {
    for (int x = first(box.x0); x < box.x1; x += stride) {
      if (!cloud.foreground(x, y)) continue;
      const int pixel = y * cloud.intrinsics.width + x;
      const Eigen::Vector3f& q = cloud.points_C[pixel];
      if ((q - center_C).squaredNorm() > reach_m * reach_m) continue;
      if (model.distance.At(X_OC * q) <= claim_m) pixels.push_back(pixel);
    }
  }
}

}  // namespace

std::vector<PoseHypothesis> SuppressDuplicates(const OrganizedCloud& cloud,
                                               const std::vector<ModelPoints>& models,
                                               std::vector<PoseHypothesis> hypotheses,
                                               const SuppressOptions& options) {
  std::stable_sort(
      hypotheses.begin(), hypotheses.end(),
      [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
  Image<uint8_t> claimed(cloud.intrinsics.width, cloud.intrinsics.height);
  std::vector<PoseHypothesis> kept;
  std::vector<int> pixels;
  for (const PoseHypothesis& h : hypotheses) {
    FindClaims(cloud, models.at(h.object), h.X_CO, options, pixels);
    const auto shared = std::count_if(pixels.begin(), pixels.end(),
                                      [&](int pixel) { return claimed.data()[pixel] != 0; });
    if (pixels.empty() || static_cast<double>(shared) >
                              options.max_shared_share * static_cast<double>(pixels.size())) {
      continue;
    }
    for (const int pixel : pixels) claimed.data()[pixel] = 1;
    kept.push_back(h);
  }
  return kept;
}

}  // namespace pickbed
