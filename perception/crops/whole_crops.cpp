#include "perception/crops/whole_crops.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "perception/features/patch.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

struct CenterPixel {
  double distance = 0;  // from the ray through the object center, in diameters
  int index = 0;
};
// Returns the pixels with this id and a reading, nearest to the ray first.
std::vector<CenterPixel> PixelsByDistance(const Image<float>& depth_m, const Image<uint16_t>& ids,
                                          uint16_t id, const CameraIntrinsics& camera,
                                          const Eigen::Vector3d& center_C, double diameter_m) {
  const Eigen::Vector2d center = Project(camera, center_C);
  const double diameter_px = camera.fx() * diameter_m / center_C.z();
  std::vector<CenterPixel> pixels;
  for (int y = 0; y < ids.height(); ++y) {
    for (int x = 0; x < ids.width(); ++x) {
      if (ids(x, y) != id || depth_m(x, y) <= 0) continue;
      pixels.push_back(
          {(Eigen::Vector2d(x, y) - center).norm() / diameter_px, y * ids.width() + x});
    }
  }
  std::sort(pixels.begin(), pixels.end(), [](const CenterPixel& a, const CenterPixel& b) {
    return std::pair(a.distance, a.index) < std::pair(b.distance, b.index);
  });
  return pixels;
}

Eigen::Vector3d PointAt(const RgbdFrame& frame, int pixel) {
  const int width = frame.depth_m.width(), x = pixel % width, y = pixel / width;
  return BackProject(frame.intrinsics, x, y, frame.depth_m(x, y));
}

Image<uint16_t> Only(const Image<uint16_t>& ids, uint16_t id) {
  Image<uint16_t> only = ids;
  for (size_t i = 0; i < only.size(); ++i) only.data()[i] = ids.data()[i] == id ? 1 : 0;
  return only;
}

// Cuts a crop around a random pixel within off_center of the ray, or around the nearest pixel if
// there is none. Returns X_PO.
Pose AppendNearCenter(const RgbdFrame& frame, const Image<uint16_t>& ids,
                      const std::vector<CenterPixel>& pixels, double off_center, double side_m,
                      const Pose& X_CO, Rng& rng, ObjectCrops& out) {
  const auto end = std::find_if(pixels.begin(), pixels.end(), [&](const CenterPixel& pixel) {
    return pixel.distance > off_center;
  });
  const int near = std::max(1, static_cast<int>(end - pixels.begin()));
  const CropSpot spot{PointAt(frame, pixels[rng.Index(near)].index), side_m};
  AppendCrop(frame, spot, &ids, out.crops);
  const Pose X_PO = PatchFrame(spot.center_C, 0).inverse() * X_CO;
  out.R_CO.push_back(X_PO.linear());
  return X_PO;
}

void AppendIsolated(LabelledViewSource& views, ObjectId object, const WholeViewOptions& options,
                    Rng& rng, ObjectCrops& out) {
  const ObjectModel& model = *views.objects()[object];
  Rotations R_CO(options.isolated);
  for (Eigen::Matrix3d& R : R_CO) R = rng.Rotation().toRotationMatrix();
  ForEachCropView(views, object, R_CO, options.templates, rng.Next(), [&](const LabelledView& v) {
    const Pose& X_CO = v.instances.front().X_CO;
    const auto pixels = PixelsByDistance(v.frame.depth_m, v.ids, 1, v.frame.intrinsics,
                                         X_CO * CropCenter_O(model), model.diameter_m);
    if (pixels.empty()) return;
    AppendNearCenter(v.frame, v.ids, pixels, options.off_center,
                     CropSide_m(model, options.templates), X_CO, rng, out);
  });
}

void AppendScene(LabelledViewSource& views, ObjectId object, const WholeViewOptions& options,
                 Rng& rng, ObjectCrops& out) {
  const ObjectModel& model = *views.objects()[object];
  for (const LabelledView& view :
       views.ClutterScene({rng.Next(), options.views_per_scene, object, true})) {
    const OrganizedCloud cloud = BuildCloud(view.frame, view.background);
    const RgbdFrame frame = ForegroundFrame(cloud);
    for (size_t k = 0; k < view.instances.size(); ++k) {
      const LabelledInstance& instance = view.instances[k];
      if (instance.object != object || instance.visible_fraction < options.min_visible) continue;
      const uint16_t id = static_cast<uint16_t>(k + 1);
      const auto pixels = PixelsByDistance(frame.depth_m, view.ids, id, frame.intrinsics,
                                           instance.X_CO * CropCenter_O(model), model.diameter_m);
      if (pixels.empty()) continue;
      AppendNearCenter(frame, Only(view.ids, id), pixels, options.off_center,
                       CropSide_m(model, options.templates), instance.X_CO, rng, out);
    }
  }
}

}  // namespace

void WholeViewOptions::Visit(SettingsVisitor& v) {
  v.Group(
      "templates", [&](SettingsVisitor& g) { templates.Visit(g); }, "views of the templates");
  v.RenamedKey("alone", "isolated");
  v.Integer("isolated", isolated, {0, 1000000}, "number of training views of an isolated object");
  v.RenamedKey("piles", "clutter_scenes");
  v.Integer("clutter_scenes", clutter_scenes, {0, 100000},
            "number of clutter scenes for training, per object");
  v.RenamedKey("views_per_pile", "views_per_scene");
  v.Integer("views_per_scene", views_per_scene, {1, 100}, "number of views of each clutter scene");
  v.Real("min_visible", min_visible, {0, 1}, "minimum visible fraction of a training instance");
  v.Real("off_center", off_center, {0, 1},
         "maximum distance of a training crop's point from the ray through the object center, "
         "diameters");
}

WholeTemplates MakeWholeTemplates(LabelledViewSource& views, ObjectId object,
                                  const CropViewOptions& options, uint64_t seed) {
  constexpr double kNearestOnly = 0;
  const ObjectModel& model = *views.objects()[object];
  Rng rng = Rng::Derive(seed, object, "whole templates");
  WholeTemplates templates;
  templates.crops.object = object;
  const Rotations R_CO = TemplateRotations(options);
  ForEachCropView(views, object, R_CO, options, rng.Next(), [&](const LabelledView& view) {
    const Pose& X_CO = view.instances.front().X_CO;
    const auto pixels = PixelsByDistance(view.frame.depth_m, view.ids, 1, view.frame.intrinsics,
                                         X_CO * CropCenter_O(model), model.diameter_m);
    CheckInput(
        !pixels.empty(),
        fmt::format("a view of object '{}' shows nothing of it; check its mesh", model.name));
    templates.X_PO.push_back(AppendNearCenter(view.frame, view.ids, pixels, kNearestOnly,
                                              CropSide_m(model, options), X_CO, rng,
                                              templates.crops));
  });
  return templates;
}

CropTrainingSet MakeWholeTrainingSet(LabelledViewSource& views, const WholeViewOptions& options,
                                     uint64_t seed,
                                     const std::function<bool(double share)>& on_share) {
  CheckSettings("WholeViewOptions", options);
  CropTrainingSet training_set{views.objects(), {}, {}};
  const int object_count = static_cast<int>(training_set.objects.size());
  const auto goes_on = [&](double done) { return !on_share || on_share(done / object_count); };
  for (ObjectId object{0}; object < object_count; ++object) {
    training_set.templates.push_back(
        MakeWholeTemplates(views, object, options.templates, seed).crops);
    ObjectCrops& training = training_set.training.emplace_back();
    training.object = object;
    Rng rng = Rng::Derive(seed, object, "whole lesson");
    AppendIsolated(views, object, options, rng, training);
    for (int clutter_scene = 0; clutter_scene < options.clutter_scenes; ++clutter_scene) {
      if (!goes_on(object + static_cast<double>(clutter_scene) / options.clutter_scenes))
        return training_set;
      AppendScene(views, object, options, rng, training);
    }
  }
  return training_set;
}

RgbdFrame ForegroundFrame(const OrganizedCloud& cloud) {
  RgbdFrame frame{cloud.intrinsics, {}, cloud.depth_m};
  for (size_t i = 0; i < frame.depth_m.size(); ++i) {
    if (!cloud.foreground.data()[i]) frame.depth_m.data()[i] = 0;
  }
  return frame;
}

std::vector<int> GridProposals(const OrganizedCloud& cloud, int grid_px) {
  std::vector<int> pixels;
  const int width = cloud.depth_m.width();
  for (const int pixel : cloud.foreground_pixels) {
    const int x = pixel % width, y = pixel / width;
    if (x % grid_px == grid_px / 2 && y % grid_px == grid_px / 2) pixels.push_back(pixel);
  }
  return pixels;
}

CropSet CutWholeCrops(const OrganizedCloud& cloud, const std::vector<int>& pixels, double side_m) {
  const RgbdFrame frame = ForegroundFrame(cloud);
  CropSet crops;
  for (const int pixel : pixels) AppendCrop(frame, {PointAt(frame, pixel), side_m}, nullptr, crops);
  return crops;
}

}  // namespace pickbed::perception
