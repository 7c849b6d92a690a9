#include "eval/draw/family_sheet.h"

#include <fmt/format.h>

#include "eval/draw/outline.h"
#include "eval/draw/overlay.h"
#include "scenes/shape_families/sampled_names.h"
#include "scenes/shape_families/solid_mesh.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector3d;

constexpr int kFamilyTileWidth = 180, kFamilyTileHeight = 150, kFamilyColumns = 6;
constexpr double kFamilyDistance = 3;    // of the camera, in diameters
constexpr double kFamilyFocal_px = 430;  // a diameter nearly fills the height of a tile
constexpr Rgb8 kFamilyPaper{238, 240, 243};
// Many shapes are open towards z or along it.
const Vector3d kFamilyView(0.7, -1.0, 1.1);

}  // namespace

Image<Rgb8> FamilySheet(ShapeSplit split, uint64_t seed) {
  Renderer renderer;
  std::vector<Image<Rgb8>> tiles;
  std::vector<std::string> captions;
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    const SampledShape shape = SampleShape(row, split, seed);
    TriangleMesh mesh = MeshOfSolid(shape.solid);
    mesh.base_color = SampledColor(shape);
    const double distance_m = kFamilyDistance * MeshBounds(mesh).size().norm();
    const Camera camera = CameraTowards(Vector3d::Zero(), kFamilyView, distance_m, kFamilyTileWidth,
                                        kFamilyTileHeight, kFamilyFocal_px);
    Light light;
    light.position_W = camera.X_WC() * Vector3d(-0.5, -0.6, -0.3);
    const double size_mm = 1e3 * MeshBounds(mesh).size().maxCoeff();
    const RenderInstance instance{renderer.AddMesh(mesh), Pose::Identity(), 1};
    RenderedImage image = renderer.Render(camera, std::vector{instance}, light);
    for (size_t i = 0; i < image.color.size(); ++i) {
      if (image.depth_m.data()[i] == 0) image.color.data()[i] = kFamilyPaper;
    }
    tiles.push_back(std::move(image.color));
    captions.push_back(fmt::format("{}{} {:.0f} mm", row.name, row.held_out ? "*" : "", size_mm));
  }
  return ContactSheet(tiles, captions, kFamilyColumns);
}

}  // namespace pickbed::eval
