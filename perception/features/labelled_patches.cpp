#include "perception/features/labelled_patches.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

// Number of views rendered in one call.
constexpr int kBlock = 256;

std::vector<double> RandomAngles(size_t count, Rng& rng) {
  std::vector<double> angles(count);
  for (double& angle : angles) angle = rng.Uniform(0, 2 * std::numbers::pi);
  return angles;
}

// Draws with replacement.
std::vector<int> Draw(const std::vector<int>& from, int count, Rng& rng) {
  std::vector<int> drawn(count);
  for (int& pixel : drawn) pixel = from[rng.Index(static_cast<int>(from.size()))];
  return drawn;
}

std::vector<Pose> RandomPoses(const ObjectModel& model, const IsolatedOptions& options, int count,
                              Rng& rng) {
  const Pose X_OM = Translation(MeshBounds(model.mesh_O).center());
  std::vector<Pose> poses(count);
  for (Pose& X_CO : poses) {
    const double z =
        options.distance_m * rng.Uniform(1 - options.distance_spread, 1 + options.distance_spread);
    const Pose X_CM = MakePose(rng.Rotation().toRotationMatrix(), {0, 0, z});
    X_CO = X_CM * X_OM.inverse();
  }
  return poses;
}

}  // namespace

void IsolatedOptions::Visit(SettingsVisitor& v) {
  v.Integer("views", views, {1, 1000000}, "number of isolated views per object");
  v.Integer("patches_per_view", patches_per_view, {1, 1000}, "number of patches per isolated view");
  v.Real("distance_m", distance_m, {0.01, 100}, "distance from the camera to the object, m");
  v.Real("distance_spread", distance_spread, {0, 0.9}, "relative spread of the camera distance");
  v.Real("focal_px", focal_px, {1, 1e6}, "focal length, px");
}

CameraIntrinsics CropCamera(double diameter_m, const IsolatedOptions& options) {
  constexpr int kBorder = 3;  // px, for the lateral jitter of the sensor
  const double nearest = options.distance_m * (1 - options.distance_spread) - 0.5 * diameter_m;
  const double radius_px = options.focal_px * 0.5 * diameter_m / std::max(nearest, 1e-3);
  const int size = 2 * (static_cast<int>(std::ceil(radius_px)) + kBorder);
  const double center_px = 0.5 * (size - 1);
  return {size, size, options.focal_px, options.focal_px, center_px, center_px};
}

void ForEachIsolatedBlock(LabelledViewSource& views, ObjectId object, const PatchForm& form,
                          const IsolatedOptions& options, uint64_t seed,
                          const std::function<bool(LabelledPatches, double)>& take) {
  CheckSettings("IsolatedOptions", options);
  const ObjectModel& model = *views.objects()[object];
  // The object rotates about the center of its bounding box.
  const CameraIntrinsics camera = CropCamera(MeshBounds(model.mesh_O).size().norm(), options);
  for (int first = 0; first < options.views; first += kBlock) {
    const int count = std::min(kBlock, options.views - first);
    Rng rng = Rng::Derive(seed, first, "isolated/" + model.name);
    const std::vector<Pose> poses = RandomPoses(model, options, count, rng);
    LabelledPatches patches;
    for (const LabelledView& view : views.Isolated(object, poses, camera, rng.Next())) {
      const OrganizedCloud cloud = IsolatedCloud(view);
      const std::vector<int> pixels = PixelsByInstance(view, cloud).at(0);
      if (pixels.empty()) continue;
      const std::vector<int> drawn = Draw(pixels, options.patches_per_view, rng);
      AppendPatches(cloud, drawn, RandomAngles(drawn.size(), rng), form, view.instances.at(0).X_CO,
                    patches);
    }
    if (!take(std::move(patches), static_cast<double>(first + count) / options.views)) return;
  }
}

void AppendPatches(const OrganizedCloud& cloud, std::span<const int> pixels,
                   std::span<const double> angles_rad, const PatchForm& form, const Pose& X_CO,
                   LabelledPatches& patches) {
  const PatchSet cut = CutPatches(cloud, pixels, angles_rad, form);
  patches.values.insert(patches.values.end(), cut.values.begin(), cut.values.end());
  for (const Pose& X_CP : cut.X_CP) patches.X_PO.push_back(X_CP.inverse() * X_CO);
}

void AppendPatch(const LabelledPatches& from, size_t row, LabelledPatches& to) {
  const auto patch = from.patch(row);
  to.values.insert(to.values.end(), patch.begin(), patch.end());
  to.X_PO.push_back(from.X_PO[row]);
}

void AppendAll(const LabelledPatches& from, LabelledPatches& to) {
  to.values.insert(to.values.end(), from.values.begin(), from.values.end());
  to.X_PO.insert(to.X_PO.end(), from.X_PO.begin(), from.X_PO.end());
}

OrganizedCloud IsolatedCloud(const LabelledView& view) {
  return BuildCloud(view.frame, std::nullopt, {.min_plane_share = 1});
}

std::vector<std::vector<int>> PixelsByInstance(const LabelledView& view,
                                               const OrganizedCloud& cloud) {
  std::vector<std::vector<int>> pixels(view.instances.size());
  for (const int pixel : cloud.foreground_pixels) {
    const uint16_t id = view.ids.pixels()[pixel];
    if (id > 0 && id <= pixels.size()) pixels[id - 1].push_back(pixel);
  }
  return pixels;
}

}  // namespace pickbed::perception
