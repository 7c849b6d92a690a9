#include "eval/export/visibility_csv.h"

#include <fmt/format.h>

#include "scenes/base/ids_format.h"

namespace pickbed::eval {

ResultColumns VisibilityColumns() {
  return {
      {"id", "value of the instance in ids.png"},
      {"instance", "number of the instance in its bin"},
      {"object", "name of the object"},
      {"visible_fraction", "visible fraction in the image", "0..1"},
  };
}

std::string VisibilityCsv(const Scene& scene, const Observation& view, const ObjectSet& objects) {
  std::string csv = HeaderLine(VisibilityColumns());
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    csv += fmt::format("{},{},{},{}\n", posed.instance + 1, posed.instance,
                       objects[posed.object]->name, view.visible_fractions[i]);
  }
  return csv;
}

}  // namespace pickbed::eval
