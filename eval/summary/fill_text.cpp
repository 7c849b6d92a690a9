#include "eval/summary/fill_text.h"

#include <fmt/format.h>

#include "eval/stats/statistics.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {

std::string FillText(const ScenarioSpec& spec, const ObjectSet& objects) {
  constexpr double kLitre_m3 = 1e-3;
  const double bin_m3 = spec.bin.inner_size_m.prod();
  if (spec.fill > 0) {
    return fmt::format("A bin of {:.3g} l gets {} of its height.", bin_m3 / kLitre_m3,
                       ObjectsInWords(spec));
  }
  if (spec.draw > 0) {
    return fmt::format("A bin of {:.3g} l draws {}.", bin_m3 / kLitre_m3, ObjectsInWords(spec));
  }
  double objects_m3 = 0;
  int count = 0;
  for (size_t i = 0; i < objects.size(); ++i) {
    count += spec.objects[i].count;
    objects_m3 += spec.objects[i].count * objects[i]->mass.volume_m3;
  }
  const std::string what = fmt::format("{} {} of {:.3g} l in all", count,
                                       count == 1 ? "object" : "objects", objects_m3 / kLitre_m3);
  if (!(bin_m3 > 0)) return fmt::format("A table without walls gets {}.", what);
  return fmt::format("A bin of {:.3g} l gets {}: {} of its volume.", bin_m3 / kLitre_m3, what,
                     PercentText(objects_m3 / bin_m3));
}

}  // namespace pickbed::eval
