#include "scenes/scenario/scenario_text.h"

#include <fmt/format.h>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

std::string ScenarioText(ScenarioSpec spec, const std::filesystem::path& folder) {
  if (!spec.bin.mesh.empty()) {
    spec.bin.mesh = std::filesystem::relative(spec.folder / spec.bin.mesh, folder).string();
  }
  for (ObjectSpec& object : spec.objects) {
    if (!object.mesh.empty()) {
      object.mesh = std::filesystem::relative(spec.folder / object.mesh, folder).string();
    }
  }
  return WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
}

ScenarioSpec ScenarioOfText(const std::string& text, const std::filesystem::path& folder,
                            const std::string& name) {
  ScenarioSpec spec;
  ReadSettingsText(text, name, [&](SettingsVisitor& v) { spec.Visit(v); });
  spec.folder = std::filesystem::absolute(folder);
  return spec;
}

std::string ObjectsInWords(const ScenarioSpec& spec) {
  const bool filled = spec.fill > 0;
  constexpr size_t kNamedObjects = 8;  // a larger pool is only counted
  if (spec.draw > 0 && spec.objects.size() > kNamedObjects) {
    return fmt::format("{} of {} objects", spec.draw, spec.objects.size());
  }
  std::string words;
  for (const ObjectSpec& object : spec.objects) {
    if (!words.empty()) words += filled ? " : " : ", ";
    const bool alone = filled && spec.objects.size() == 1;
    words += alone ? object.name : fmt::format("{} {}", object.count, object.name);
  }
  if (spec.draw > 0) return fmt::format("{} of: {}", spec.draw, words);
  return filled ? fmt::format("{}, filled to {:.0f} %", words, 100 * spec.fill) : words;
}

}  // namespace pickbed::scenes
