// Meshes and images of a BOP data set.

#include <fmt/format.h>

#include "eval/bop/dataset.h"
#include "eval/bop/layout.h"
#include "scenes/check.h"
#include "scenes/image_io.h"
#include "scenes/object_catalog.h"

namespace pickbed::bop {

namespace fs = std::filesystem;

std::shared_ptr<const ObjectModel> LoadModel(const fs::path& folder, int object_id,
                                             const ModelInfo& info, const std::string& name) {
  constexpr double kAnyMass_kg = 0.1;  // no pose depends on it
  MeshPartSpec spec;
  spec.mesh = folder / ModelFileName(object_id);
  spec.unit = "mm";
  spec.mass_kg = kAnyMass_kg;
  spec.symmetries_O = info.symmetries_O;
  auto model = std::make_shared<ObjectModel>(*LoadMeshPart(name, spec));
  model->diameter_m = info.diameter_m;  // the published one is what thresholds refer to
  return model;
}

RgbdFrame ReadDepthFrame(const SceneTruth& scene, const ImageTruth& image) {
  const auto file = DepthFile(scene.folder, image.image_id);
  CheckInput(file.has_value(),
             fmt::format("{}: is missing",
                         (scene.folder / "depth" / ImageFileName(image.image_id)).string()));
  const Image<uint16_t> units = ReadPng16(*file);
  RgbdFrame frame;
  frame.intrinsics = image.intrinsics;
  frame.intrinsics.width = units.width();
  frame.intrinsics.height = units.height();
  frame.depth_m = Image<float>(units.width(), units.height());
  const double unit_m = 1e-3 * image.depth_scale_mm;
  for (size_t i = 0; i < units.size(); ++i) {
    frame.depth_m.data()[i] = static_cast<float>(unit_m * units.data()[i]);
  }
  return frame;
}

RgbdFrame ReadFrame(const SceneTruth& scene, const ImageTruth& image) {
  RgbdFrame frame = ReadDepthFrame(scene, image);
  const auto file = ColorFile(scene.folder, image.image_id);
  CheckInput(file.has_value(),
             fmt::format("{}: is missing",
                         (scene.folder / "rgb" / ImageFileName(image.image_id)).string()));
  frame.color = ReadPng(*file);
  CheckInput(frame.color.width() == frame.depth_m.width() &&
                 frame.color.height() == frame.depth_m.height(),
             fmt::format("{}: is {} x {} pixels, its depth image {} x {}", file->string(),
                         frame.color.width(), frame.color.height(), frame.depth_m.width(),
                         frame.depth_m.height()));
  return frame;
}

}  // namespace pickbed::bop
