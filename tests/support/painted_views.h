#pragma once

// Ray-cast views with color: object 0 is red, all others are blue.

#include "scenes/base/ids.h"
#include "tests/support/ray_cast_views.h"

namespace pickbed::tests {

class PaintedViews : public RayCastViews {
 public:
  using RayCastViews::RayCastViews;

  std::vector<LabelledView> Isolated(ObjectId object, const std::vector<Pose>& X_CO,
                                     const CameraIntrinsics& camera, uint64_t seed) override {
    std::vector<LabelledView> views = RayCastViews::Isolated(object, X_CO, camera, seed);
    for (LabelledView& view : views) Paint(view);
    return views;
  }
  std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) override {
    std::vector<LabelledView> views = RayCastViews::ClutterScene(request);
    for (LabelledView& view : views) Paint(view);
    return views;
  }

 private:
  static void Paint(LabelledView& view) {
    view.frame.color = Image<Rgb8>(view.ids.width(), view.ids.height());
    for (size_t p = 0; p < view.ids.size(); ++p) {
      const uint16_t id = view.ids.pixels()[p];
      if (id == 0) continue;
      view.frame.color.pixels()[p] =
          view.instances[id - 1].object == 0 ? Rgb8{220, 40, 40} : Rgb8{40, 40, 220};
    }
  }
};

}  // namespace pickbed::tests
