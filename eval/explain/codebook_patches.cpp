#include "eval/explain/codebook_patches.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "perception/features/labelled_patches.h"

namespace pickbed::eval {
namespace {

// Smallest camera image for the patch, with a margin for sensor jitter and the fit of normals. The
// patch center is a pixel center.
CameraIntrinsics PatchCamera(double side_m, double distance_m, double focal_px) {
  constexpr double kRoom = 1.2;
  constexpr int kBorder_px = 6;
  const double half_px = 0.5 * kRoom * side_m * focal_px / std::max(1e-3, distance_m - side_m);
  const int half = static_cast<int>(std::ceil(half_px)) + kBorder_px;
  const int size = 2 * half + 1;
  const double center_px = half;
  return {size, size, focal_px, focal_px, center_px, center_px};
}

}  // namespace

std::vector<std::optional<std::array<int8_t, kPatchValues>>> EntryPatches(
    LabelledViewSource& views, const std::vector<EntryPose>& entries, double distance_m,
    double focal_px) {
  const Pose X_CP = PatchFrame({0, 0, distance_m}, 0);
  using Kind = std::tuple<ObjectId, double, PatchChannels>;  // object and form
  std::map<Kind, std::vector<size_t>> by_kind;
  for (size_t i = 0; i < entries.size(); ++i) {
    const PatchForm& form = entries[i].form;
    by_kind[{entries[i].object, form.side_m, form.channels}].push_back(i);
  }
  std::vector<std::optional<std::array<int8_t, kPatchValues>>> patches(entries.size());
  for (const auto& [kind, members] : by_kind) {
    const auto [object, side_m, channels] = kind;
    const CameraIntrinsics camera = PatchCamera(side_m, distance_m, focal_px);
    std::vector<Pose> X_CO;
    for (const size_t i : members) X_CO.push_back(X_CP * entries[i].X_PO);
    const std::vector<LabelledView> seen = views.Isolated(object, X_CO, camera, 0);
    const int center_pixel = camera.height() / 2 * camera.width() + camera.width() / 2;
    for (size_t m = 0; m < members.size(); ++m) {
      const OrganizedCloud cloud = IsolatedCloud(seen[m]);
      if (!(cloud.depth_m.data()[center_pixel] > 0)) continue;
      const double angle = 0;
      const PatchSet patch = CutPatches(cloud, {&center_pixel, 1}, {&angle, 1}, {side_m, channels});
      std::ranges::copy(patch.patch(0), patches[members[m]].emplace().begin());
    }
  }
  return patches;
}

}  // namespace pickbed::eval
