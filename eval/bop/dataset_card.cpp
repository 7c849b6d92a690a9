#include "eval/bop/dataset_card.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "eval/bop/json.h"
#include "eval/bop/layout.h"
#include "eval/bop/write_scene.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "sim/sensor/depth_noise.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

uint64_t HashText(const std::string& text, uint64_t seed) {
  return HashBytes(text.data(), text.size(), seed);
}

std::string HashOfFolder(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  uint64_t hash = HashText("", 14695981039346656037ull);
  for (const fs::path& file : files) {
    hash = HashText(file.lexically_relative(folder).string(), hash);
    hash = HashText(ReadFileBytes(file), hash);
  }
  return fmt::format("{:016x}", hash);
}

std::string CardText(const ParsedJson& card) {
  const int views = card["views"].get<int>();
  std::string text = fmt::format(
      "# A simulated BOP data set\n\n{} scenes of {} in `{}`, made by pickbed from the "
      "scenario below with seed {}.\n\n| object | name | mesh hash |\n|---|---|---|\n",
      card["scenes"].get<int>(),
      views > 0 ? fmt::format("{} views", views) : "one image per attempt of a picking run",
      card["split"].get<std::string>(), card["seed"].get<uint64_t>());
  for (const ParsedJson& object : card["objects"]) {
    text += fmt::format("| {} | {} | {} |\n", object["obj_id"].get<int>(),
                        object["name"].get<std::string>(), object["mesh"].get<std::string>());
  }
  text += fmt::format(
      "\nDefinitions: visibility is exact, computed from the image of instance ids; silhouettes "
      "count beyond the image border; `depth` has the sensor's noise, {} mm per unit. Scenes are "
      "settled and certified: no object is inside another by more than 0.5 mm.\n\nHash of all "
      "scenes: {}\n\n```yaml\n{}```\n",
      kDepthScale_mm, card["hash"].get<std::string>(), card["settings"].get<std::string>());
  return text;
}

// Returns the hash of a text of 16 hexadecimal digits.
uint64_t HashIn(const ParsedJson& text) {
  constexpr size_t kDigits = 16;
  const auto digits = text.get<std::string>();
  const char* const end = digits.data() + digits.size();
  uint64_t hash = 0;
  const auto [after, error] = std::from_chars(digits.data(), end, hash, 16);
  CheckInput(digits.size() == kDigits && error == std::errc() && after == end,
             fmt::format("'{}' is no hash", OneLine(digits)));
  return hash;
}

// Returns the last line of the settings of a dataset, which has the split and the views.
std::string SplitLine(const std::string& settings) {
  const size_t end = settings.find_last_not_of('\n') + 1;
  const size_t before = settings.rfind('\n', end - 1);
  const size_t begin = before == settings.npos ? 0 : before + 1;
  return settings.substr(begin, end - begin);
}

// Throws InputError for a damaged value of the card. `identity`: ReadIdentity(), which may be of
// another split whose card is not written yet.
void CheckCard(const ParsedJson& card, const std::string& identity) {
  const auto settings = card.at("settings").get<std::string>();
  CheckInput(settings == identity || SplitLine(settings) != SplitLine(identity),
             fmt::format("its settings differ from {}", kDatasetSettingsFile));
  if (card.contains("hash")) HashIn(card.at("hash"));
  // A dataset without a scene has no hashes.
  if (!card.contains("scene_hashes")) return;
  for (const ParsedJson& hash : card.at("scene_hashes")) HashIn(hash);
}

}  // namespace

std::string IdentityOf(const ScenarioSpec& spec, const ObjectSet& objects,
                       const MakeDatasetOptions& options) {
  ScenarioSpec same_for_all = spec;
  same_for_all.trials = 1;
  std::string text = WriteSettings([&](SettingsVisitor& v) { same_for_all.Visit(v); });
  SensorProfile sensor =
      WithSettingsKey(spec, "sensor", [&] { return LoadSensorProfile(spec.sensor); });
  text += "# sensor\n";
  std::string profile = WriteSettings([&](SettingsVisitor& v) { sensor.Visit(v); });
  for (size_t begin = 0, end = 0; (end = profile.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    text += "# " + profile.substr(begin, end - begin) + "\n";
  }
  for (const auto& object : objects) {
    text += fmt::format("# part {} is {:016x}\n", object->name, object->mesh_hash);
  }
  return text + fmt::format("# {} views of each scene in {}\n", options.views, options.split);
}

std::string ReadIdentity(const fs::path& out) {
  return fs::exists(out / kDatasetSettingsFile) ? ReadFileBytes(out / kDatasetSettingsFile)
                                                : std::string();
}

void WriteIdentity(const fs::path& out, const std::string& identity) {
  WriteFileAtomically(out / kDatasetSettingsFile, identity);
}

void WriteCards(const ScenarioSpec& spec, const ObjectSet& objects,
                const MakeDatasetOptions& options, const std::string& identity) {
  ParsedJson card{{"format", "BOP-scenewise"},
                  {"seed", spec.seed},
                  {"views", options.views},
                  {"split", options.split},
                  {"settings", identity}};
  for (size_t i = 0; i < objects.size(); ++i) {
    card["objects"].push_back({{"obj_id", i + 1},
                               {"name", objects[i]->name},
                               {"mesh", fmt::format("{:016x}", objects[i]->mesh_hash)}});
  }
  const std::vector<int> scenes = SceneIdsOf(options.out, options.split);
  card["scenes"] = scenes.size();
  std::string all;
  for (const int id : scenes) {
    const std::string name = SceneFolderName(id);
    const std::string hash = HashOfFolder(options.out / options.split / name);
    card["scene_hashes"][name] = hash;
    all += hash;
  }
  card["models"] = HashOfFolder(options.out / "models");
  card["hash"] = fmt::format("{:016x}", HashBytes(all.data(), all.size()));
  WriteFileAtomically(options.out / kCardFile, card.dump(2) + "\n");
  WriteFileAtomically(options.out / kCardTextFile, CardText(card));
}

std::map<int, CardObject> ObjectsOfCard(const fs::path& root) {
  const fs::path file = root / kCardFile;
  std::map<int, CardObject> objects;
  if (!fs::exists(file)) return objects;
  const std::optional<ParsedJson> card = ReadJson(file, ThrowFault);
  try {
    if (card->at("models").get<std::string>() != HashOfFolder(root / "models")) return objects;
    CheckCard(*card, ReadIdentity(root));
    for (const ParsedJson& object : card->at("objects")) {
      objects[object.at("obj_id").get<int>()] = {object.at("name").get<std::string>(),
                                                 HashIn(object.at("mesh"))};
    }
  } catch (const std::exception& error) {
    throw InputError(fmt::format(
        "{}: is damaged or not written by pickbed ({}); resume `pickbed dataset make` to write it "
        "again",
        file.string(), error.what()));
  }
  return objects;
}

}  // namespace pickbed::eval
