#include "eval/benchmark/bins.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "eval/estimate/statistics.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/networks/model_file.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/verifier_library.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

using nlohmann::json;

bool Knows(const std::vector<ModelObject>& trained, const ObjectSet& objects) {
  return std::all_of(objects.begin(), objects.end(), [&](const auto& object) {
    return std::any_of(trained.begin(), trained.end(), [&](const ModelObject& known) {
      return known.name == object->name && known.mesh_hash == object->mesh_hash;
    });
  });
}

// Whether the model file of this method contains only verifiers.
bool HasOnlyVerifiers(const BinMethod& method) {
  return std::ranges::any_of(EstimatorTable(), [&](const EstimatorRow& row) {
    return std::string(method.estimator) == row.name && row.make_training &&
           row.make_training()->has_verifier_file();
  });
}

// Objects for which the file was trained. Empty if the file cannot be read.
std::vector<ModelObject> TrainedFor(const BinMethod& method, const std::filesystem::path& file) {
  try {
    return HasOnlyVerifiers(method) ? LoadVerifiers(file, method.estimator).objects
                                    : LoadModel(file).info.objects;
  } catch (const InputError&) {
    return {};
  }
}

std::filesystem::path ModelFile(const BinMethod& method, const std::filesystem::path& folder) {
  return folder / (std::string(method.model) + ".net");
}

// Words after `pickbed train` for this method, without the objects and the file.
std::vector<std::string> HowTrained(const BinMethod& method, bool small) {
  std::vector<std::string> words = method.training;
  if (small) words.insert(words.end(), method.small_training.begin(), method.small_training.end());
  return words;
}

json ToJson(const BinStatistics& bin) {
  json bands = json::array();
  for (const Cluster& band : bin.bands) bands.push_back({band.hits, band.samples});
  return {{"trial", bin.trial},
          {"top_right", bin.top_right},
          {"seconds", bin.seconds},
          {"bands", std::move(bands)}};
}

BinStatistics BinStatisticsFrom(const json& value) {
  BinStatistics bin{value.at("trial"), value.at("top_right"), value.at("seconds"), {}};
  for (const json& band : value.at("bands")) bin.bands.push_back({band.at(0), band.at(1)});
  return bin;
}

}  // namespace

const std::vector<BinMethod>& BinMethods() {
  const auto set = [](std::vector<std::string> words, const std::vector<std::string>& settings) {
    for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
    return words;
  };
  const auto few = set({}, {"clutter_scenes=6", "iterations=120", "verifier_clutter_scenes=2",
                            "verifier_room_scenes=2", "held_out.clutter_scenes=1"});
  const auto few_wholes =
      set({}, {"clutter_scenes=2", "wohlhart.views.clutter_scenes=6", "wohlhart.views.isolated=300",
               "wohlhart.network.iterations=100"});
  static const std::vector<BinMethod> methods{
      {"descriptor:fast", "descriptor", "fast", "", {}},
      {"descriptor:accurate", "descriptor", "accurate", "", {}},
      {"ppf", "ppf", "fast", "", {}},
      {"ppf:verified",
       "ppf",
       "verified",
       "ppf",
       {"--verifier-for", "ppf", "--set", "clutter_scenes=24"}},
      {"kehl", "kehl", "accurate", "kehl", {"kehl"}, few},
      {"doumanoglou", "doumanoglou", "accurate", "doumanoglou", {"doumanoglou"}, few},
      {"doumanoglou, no siamese term", "doumanoglou", "accurate", "regression",
       set({"doumanoglou"}, {"network.regression.siamese_weight=0"}), few},
      {"doumanoglou, look-up", "descriptor", "accurate", "doumanoglou", {"doumanoglou"}, few},
      {"union", "union", "accurate", "doumanoglou", {"doumanoglou"}, few},
      {"wohlhart", "wohlhart", "accurate", "wohlhart", {"wohlhart"}, few_wholes},
      {"oracle", "oracle", "fast", "", {}},
  };
  return methods;
}

BinRow BinRowOf(const ComparedRow& row) {
  BinRow result{row.label, {}, row.bop.ap(), row.bop.ar(), row.peak_memory_mib, row.setup_s};
  for (const ComparedImage& compared : row.images) {
    ComparedRow one{row.label, {compared}, {}, 0, 0};
    const ComparisonStatistics statistics = StatisticsOf(one);
    BinStatistics bin{compared.trial, statistics.top_right > 0, statistics.seconds, {}};
    for (const RecallBand& band : statistics.bands) {
      bin.bands.push_back({band.recalled, band.instances});
    }
    result.bins.push_back(std::move(bin));
  }
  return result;
}

void WriteBinScenario(const std::filesystem::path& file, const BinScenario& scenario,
                      const std::string& key) {
  json rows = json::array();
  for (const BinRow& row : scenario.rows) {
    json bins = json::array();
    for (const BinStatistics& bin : row.bins) bins.push_back(ToJson(bin));
    rows.push_back({{"label", row.label},
                    {"ap", row.ap},
                    {"ar", row.ar},
                    {"memory_mib", row.memory_mib},
                    {"setup_s", row.setup_s},
                    {"looks", std::move(bins)}});
  }
  const json all{{"key", key}, {"name", scenario.name}, {"rows", std::move(rows)}};
  WriteFileAtomically(file, all.dump(1) + "\n");
}

std::optional<BinScenario> ReadBinScenario(const std::filesystem::path& file,
                                           const std::string& key) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const json all = json::parse(ReadFileBytes(file));
    if (all.at("key") != key) return std::nullopt;
    BinScenario scenario{all.at("name"), {}};
    for (const json& value : all.at("rows")) {
      BinRow row{value.at("label"),  {}, value.at("ap"), value.at("ar"), value.at("memory_mib"),
                 value.at("setup_s")};
      for (const json& bin : value.at("looks")) row.bins.push_back(BinStatisticsFrom(bin));
      scenario.rows.push_back(std::move(row));
    }
    return scenario;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

std::vector<int> SharedBins(int all, int scenarios) {
  std::vector<int> bins;
  for (int i = 0; i < scenarios; ++i) {
    bins.push_back(std::max(1, all / scenarios + (i < all % scenarios ? 1 : 0)));
  }
  return bins;
}

std::filesystem::path TrainedModelFile(const BinMethod& method, const std::filesystem::path& folder,
                                       const ObjectSet& objects, bool small) {
  std::string text = fmt::format("{}", fmt::join(HowTrained(method, small), " "));
  for (const auto& object : objects) {
    text += fmt::format(" {} {:016x}", object->name, object->mesh_hash);
  }
  const auto key = static_cast<uint32_t>(HashBytes(text.data(), text.size()));
  return folder / fmt::format("{}-{:08x}.net", method.model, key);
}

std::vector<std::string> TrainingWords(const BinMethod& method, const std::filesystem::path& file,
                                       const ObjectSet& objects, bool small) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  std::vector<std::string> words = HowTrained(method, small);
  const std::vector<std::string> rest{"--objects", fmt::format("{}", fmt::join(names, ",")),
                                      "--out", file.string()};
  words.insert(words.end(), rest.begin(), rest.end());
  return words;
}

bool IsBegun(const std::filesystem::path& file) {
  return std::filesystem::exists(file.string() + ".checkpoint") ||
         std::filesystem::exists(UnfinishedLibrary(file));
}

std::filesystem::path FindBinModel(const BinMethod& method, const std::filesystem::path& folder,
                                   const ObjectSet& objects, bool small) {
  for (const std::filesystem::path& file :
       {ModelFile(method, folder), TrainedModelFile(method, folder, objects, small),
        ModelFile(method, AssetsDir() / "models")}) {
    if (Knows(TrainedFor(method, file), objects)) return file;
  }
  return {};
}

}  // namespace pickbed::eval
