#include "eval/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "eval/compare/paired_comparison.h"
#include "eval/page/html.h"
#include "eval/report/views_3d.h"
#include "eval/store/results_store.h"
#include "eval/store/settings_difference.h"
#include "eval/store/store_check.h"
#include "eval/summary/fill_text.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/attempt_pictures.h"
#include "eval/tolerance/pick_forecast.h"
#include "grasp/planners/table.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/scenario/load_objects.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

constexpr double kMegabyte = 1e6;
constexpr double kBase64 = 4.0 / 3;  // size increase by Base64

std::string AddressOf(const ReportRun& run, int trial) {
  return fmt::format("{}#{}", run.name, trial);
}

// Returns the PNG file as a JPEG of this width; empty without a file or if the file is damaged.
std::string JpegOf(const fs::path& file, int width_px, int quality) {
  if (file.empty()) return "";
  try {
    return EncodeJpeg(Narrowed(ReadPng(file), width_px), quality);
  } catch (const InputError&) {
    return "";  // a page without a picture is more useful than no page
  }
}

fs::path OverlayFile(const ReportRun& run, int trial, int attempt) {
  return FindPicture(PicturesOf(run.folder, trial), AttemptPicture(attempt, "overlay"));
}

// Returns the JPEG bytes; empty if the run has no readable picture of this attempt.
std::string PictureOf(const ReportRun& run, const FailedPick& pick, const ReportOptions& options) {
  const fs::path folder = PicturesOf(run.folder, pick.trial);
  const fs::path small = FindPicture(folder, FailurePicture(pick.attempt));
  if (!small.empty()) return ReadFileBytes(small);
  return JpegOf(OverlayFile(run, pick.trial, pick.attempt), options.picture.width_px,
                options.picture.quality);
}

// Returns the URL of a file, relative to the page; empty without a file or if links are off.
std::string LinkTo(const fs::path& file, const ReportOptions& options) {
  if (options.page_folder.empty() || file.empty() || !fs::is_regular_file(file)) return "";
  const fs::path folder = fs::absolute(options.page_folder).lexically_normal();
  return UrlOf(fs::absolute(file).lexically_normal().lexically_relative(folder).generic_string());
}

// Configurations of all runs in one list, with unique names.
struct AllConfigurations {
  std::vector<const ReportRun*> runs;
  std::vector<const ReportConfiguration*> configurations;
  std::vector<ConfigurationTrials> trials;  // moved out of the runs, because they can be large
};

AllConfigurations AllConfigurationsOf(const std::vector<ReportRun*>& runs) {
  AllConfigurations all;
  for (ReportRun* run : runs) {
    for (ReportConfiguration& configuration : run->configurations) {
      all.runs.push_back(run);
      all.configurations.push_back(&configuration);
      ConfigurationTrials& trials = all.trials.emplace_back(std::move(configuration.trials));
      if (runs.size() > 1 || trials.name.empty()) {
        trials.name = run->configurations.size() > 1 ? fmt::format("{}: {}", run->name, trials.name)
                                                     : run->name;
      }
    }
  }
  return all;
}

void AddGallery(const AllConfigurations& all, const ReportOptions& options,
                ReportContents& contents) {
  const std::vector<FailedPick> failed = FailedPicksOf(all.trials);
  contents.failed_picks = static_cast<int>(failed.size());
  double bytes = 0;
  int without = 0;
  for (const FailedPick& pick : SpreadOverReasons(failed, options.failures)) {
    const ReportRun& run = *all.runs[pick.configuration];
    GalleryEntry& entry = contents.gallery.emplace_back();
    entry.pick = pick;
    entry.address = AddressOf(run, pick.trial);
    if (bytes < options.pictures_mb * kMegabyte) entry.jpeg = PictureOf(run, pick, options);
    entry.link = LinkTo(OverlayFile(run, pick.trial, pick.attempt), options);
    bytes += kBase64 * entry.jpeg.size();
    without += entry.jpeg.empty();
  }
  const size_t shown = contents.gallery.size();
  if (shown < failed.size()) {
    contents.gallery_note =
        fmt::format("{} of {} failed picks, spread over the reasons; {} lists all.", shown,
                    failed.size(), kAttemptsFile);
  }
  if (without > 0) {
    contents.gallery_note += fmt::format(
        "{}{} have no picture here: a run draws pictures only for a limited number of bins (an "
        "option of `pickbed run`), a page holds at most {:.0f} MB of them, and damaged files are "
        "left out.",
        contents.gallery_note.empty() ? "" : " ",
        without == static_cast<int>(shown) ? "They" : fmt::format("{}", without),
        options.pictures_mb);
  }
}

std::string ViewTitle(const AllConfigurations& all, const ViewChoice& choice) {
  const ConfigurationTrials& configuration = all.trials[choice.configuration];
  const AttemptRecord& pick = configuration.trials[choice.trial].attempts[choice.attempt];
  const std::string outcome = pick.failure == FailureReason::kNone
                                  ? "picked"
                                  : fmt::format("failed: {}", FailureName(pick.failure));
  const std::vector<VisibleBand>& bands =
      all.configurations[choice.configuration]->spec.occlusion.bands;
  const std::string title =
      pick.band >= 0 ? fmt::format("{} % in view, {}", bands.at(pick.band).name(), outcome)
                     : fmt::format("attempt {}, {}", pick.attempt, outcome);
  return all.trials.size() > 1 ? fmt::format("{}, {}", configuration.name, title) : title;
}

// Says that a page has no room for more views, or not even for the first one.
std::string LeftOutText(size_t shown, const char* what, double limit_mb) {
  const std::string limit = fmt::format("a page holds at most {:g} MB of them.", limit_mb);
  return shown > 0
             ? fmt::format("More {}s are left out: {}", what, limit)
             : fmt::format("No {} is shown, because the first one is too large: {}", what, limit);
}

void AddViews(const AllConfigurations& all, const ObjectCatalog& catalog,
              const ReportOptions& options, ReportContents& contents) {
  std::map<size_t, std::unique_ptr<ViewMaker>> makers;  // by configuration
  double bytes = 0;
  try {
    for (const ViewChoice& choice : ChooseViews(all.trials, options.views)) {
      const ScenarioSpec& spec = all.configurations[choice.configuration]->spec;
      std::unique_ptr<ViewMaker>& maker = makers[choice.configuration];
      if (!maker) {
        maker = std::make_unique<ViewMaker>(spec, LoadObjects(spec, catalog), options);
      }
      const TrialResult& trial = all.trials[choice.configuration].trials[choice.trial];
      ReportView view{ViewTitle(all, choice),
                      AddressOf(*all.runs[choice.configuration], trial.trial),
                      maker->Glb(trial, choice.attempt)};
      bytes += kBase64 * view.glb.size();
      if (bytes > options.views_mb * kMegabyte) {
        contents.views_note += LeftOutText(contents.views.size(), "view", options.views_mb);
        return;
      }
      contents.views.push_back(std::move(view));
      contents.views_note = "Some attempts: drag to rotate, use the wheel or two fingers to zoom. ";
    }
  } catch (const InputError& error) {
    contents.views_note = fmt::format("3D views are left out: {}.", error.what());
  }
}

// Adds picks that the run recorded: failures first, and one success.
void AddAnimatedPicks(const AllConfigurations& all, const ReportOptions& options,
                      ReportContents& contents) {
  const auto file_of = [&](const ViewChoice& choice) {
    const TrialResult& trial = all.trials[choice.configuration].trials[choice.trial];
    const int attempt = trial.attempts[choice.attempt].attempt;
    return PicturesOf(all.runs[choice.configuration]->folder, trial.trial) /
           PickAnimationName(attempt);
  };
  const auto is_recorded = [&](const ViewChoice& choice) {
    return fs::is_regular_file(file_of(choice));
  };
  double bytes = 0;
  for (const ViewChoice& choice : ChooseViews(all.trials, options.animations, is_recorded)) {
    const TrialResult& trial = all.trials[choice.configuration].trials[choice.trial];
    ReportView pick{ViewTitle(all, choice), AddressOf(*all.runs[choice.configuration], trial.trial),
                    ReadFileBytes(file_of(choice))};
    bytes += kBase64 * pick.glb.size();
    if (bytes > options.animations_mb * kMegabyte) {
      contents.picks_note =
          LeftOutText(contents.picks.size(), "animated pick", options.animations_mb);
      return;
    }
    contents.picks.push_back(std::move(pick));
  }
}

// Returns the overlay of the first attempt of the first bin, if the run drew it and it is readable.
std::string FirstOverlay(const AllConfigurations& all, const ReportOptions& options) {
  constexpr int kWidth_px = 1000;
  const int trial = all.trials.front().trials.front().trial;
  return JpegOf(OverlayFile(*all.runs.front(), trial, 0), kWidth_px, options.picture.quality);
}

// Returns FillText; empty if the objects cannot be loaded.
std::string FillOf(const ScenarioSpec& spec, const ObjectCatalog& catalog) {
  try {
    return FillText(spec, LoadObjects(spec, catalog));
  } catch (const InputError&) {
    return "";
  }
}

void AddScenarios(const AllConfigurations& all, const ReportOptions& options,
                  ReportContents& contents) {
  for (size_t i = 0; i < all.runs.size(); ++i) {
    const ReportRun& run = *all.runs[i];
    const bool has_file = run.configurations.size() == 1;
    contents.scenarios.push_back({all.trials.size() > 1 ? all.trials[i].name : "",
                                  ScenarioText(all.configurations[i]->spec, run.folder),
                                  has_file ? LinkTo(run.folder / kScenarioFile, options) : ""});
  }
}

// Adds the forecasts of the tolerance maps to each configuration, by the maps of its gripper.
void AddForecasts(const AllConfigurations& all, const ObjectCatalog& catalog,
                  const ReportOptions& options, ReportContents& contents) {
  if (options.tolerance.empty()) return;
  for (size_t i = 0; i < contents.configurations.size(); ++i) {
    const ScenarioSpec& spec = all.configurations[i]->spec;
    const ObjectSet objects = LoadObjects(spec, catalog);
    contents.configurations[i].summary.forecasts =
        ForecastsOf(all.trials[i].trials, objects, MapsFor(spec, objects, options.tolerance));
  }
}

std::string PageOf(const AllConfigurations& all, ReportContents contents,
                   const ObjectCatalog& catalog, const ReportOptions& options) {
  contents.configurations = ReportOn(all.trials, options);
  AddForecasts(all, catalog, options, contents);
  contents.overlay_jpeg = FirstOverlay(all, options);
  AddGallery(all, options, contents);
  AddAnimatedPicks(all, options, contents);
  AddViews(all, catalog, options, contents);
  AddScenarios(all, options, contents);
  return ReportPage(contents);
}

std::string MethodText(const ScenarioSpec& spec) {
  if (!PlannerNamed(spec.planner.name).needs_poses) {
    return fmt::format("planner {} without poses", spec.planner.name);
  }
  const EstimatorSpec& estimator = spec.estimator;
  if (estimator.name == "oracle") {
    return fmt::format("estimator oracle with noise of {:g} mm and {:g} deg", estimator.noise_mm,
                       estimator.noise_deg);
  }
  return fmt::format("estimator {} ({}), refiner {}", estimator.name, estimator.mode, spec.refiner);
}

std::string SettingsText(const ScenarioSpec& spec, const ObjectCatalog& catalog) {
  const std::string errors = CellErrorsInWords(spec.cell);
  return fmt::format("Bins of {}; sensor {}, {}, gripper {}, seed {}.{} {}", ObjectsInWords(spec),
                     spec.sensor, MethodText(spec), spec.gripper.InWords(), spec.seed,
                     errors.empty() ? "" : fmt::format(" Errors of the cell: {}.", errors),
                     FillOf(spec, catalog));
}

// Errors of the cell in the configurations of a sweep; empty if there are none.
std::string CellErrorsText(const ReportRun& run) {
  std::string by_configuration;
  std::set<std::string> different;
  for (const ReportConfiguration& configuration : run.configurations) {
    const std::string errors = CellErrorsInWords(configuration.spec.cell);
    different.insert(errors);
    by_configuration += fmt::format("{}{}: {}", by_configuration.empty() ? "" : "; ",
                                    configuration.trials.name, errors.empty() ? "none" : errors);
  }
  if (different.size() > 1) return fmt::format("Errors of the cell: {}.", by_configuration);
  const std::string& errors = *different.begin();
  return errors.empty() ? "" : fmt::format("Errors of the cell: {}.", errors);
}

// A plain run has its scenario file next to its store. The user may have changed settings there
// that do not affect the results.
ScenarioSpec SpecOf(const StoredConfiguration& configuration, size_t configurations,
                    const fs::path& folder) {
  const fs::path file = folder / kScenarioFile;
  if (configurations == 1 && fs::is_regular_file(file)) return LoadScenario(file);
  return LoadScenarioText(configuration.settings, folder, (folder / kStoreFile).string());
}

std::vector<PairedConfiguration> PairedConfigurationsOf(const AllConfigurations& all) {
  std::vector<PairedConfiguration> configurations;
  for (size_t i = 0; i < all.trials.size(); ++i) {
    configurations.push_back({&all.trials[i], all.configurations[i]->identity});
  }
  return configurations;
}

// Indices of two configurations to be compared.
struct PointPair {
  size_t a = 0, b = 0;
};

std::vector<PointPair> PairsOf(const ReportRun& a, const ReportRun& b) {
  if (a.configurations.size() == 1 && b.configurations.size() == 1) return {{0, 0}};
  std::vector<PointPair> pairs;
  for (size_t i = 0; i < a.configurations.size(); ++i) {
    for (size_t k = 0; k < b.configurations.size(); ++k) {
      if (a.configurations[i].trials.name == b.configurations[k].trials.name)
        pairs.push_back({i, k});
    }
  }
  CheckInput(
      !pairs.empty(),
      fmt::format(
          "{} and {} have no configuration in common (compared by name), so nothing is compared",
          a.name, b.name));
  return pairs;
}

// Returns the settings that differ between compared configurations, one row each.
TableCells DifferentSettingsOf(const ReportRun& a, const ReportRun& b,
                               const std::vector<PointPair>& pairs) {
  const bool many = pairs.size() > 1;
  TableCells cells{{"setting", a.name, b.name}};
  if (many) cells[0].insert(cells[0].begin(), "configuration");
  for (const PointPair& pair : pairs) {
    const ReportConfiguration &before = a.configurations[pair.a], &after = b.configurations[pair.b];
    for (const SettingDifference& difference : DifferentSettings(before.identity, after.identity)) {
      cells.push_back({SettingInWords(difference.key), difference.before, difference.now});
      if (many) cells.back().insert(cells.back().begin(), before.trials.name);
    }
  }
  return cells;
}

// Crashed trials are not part of any rate.
std::string CrashedText(const ReportRun& run) {
  if (run.crashed.empty()) return "";
  return fmt::format("{}: {} trials crashed and are not counted, the first is {}.", run.name,
                     run.crashed.size(), AddressOf(run, run.crashed.front()));
}

}  // namespace

ReportRun ReadReportRun(const fs::path& folder) {
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  ReportRun run{(folder / "").parent_path().string(), folder, {}, {}, {}};
  const std::vector<CrashedTrial> all_crashed = store.Crashed();
  for (const StoredConfiguration& stored : store.head().configurations) {
    ReportConfiguration configuration;
    configuration.trials.trials =
        store.Read(stored.first_trial, stored.first_trial + stored.trials);
    if (configuration.trials.trials.empty()) continue;
    configuration.spec = SpecOf(stored, store.head().configurations.size(), folder);
    configuration.identity = stored.identity;
    configuration.trials.name = stored.name;
    configuration.trials.cycle = configuration.spec.cycle;
    configuration.trials.bands = ReportedBands(configuration.spec.occlusion);
    for (const ObjectSpec& object : configuration.spec.objects)
      configuration.trials.objects.push_back(object.name);
    for (const TrialResult& trial : configuration.trials.trials) {
      CheckTrial(trial,
                 {configuration.spec.objects.size(), configuration.spec.occlusion.bands.size()},
                 (folder / kStoreFile).string());
    }
    std::vector<BinIndex> crashed_bins;
    for (const CrashedTrial& crashed : all_crashed) {
      if (crashed.configuration == stored.number) crashed_bins.push_back(crashed.bin_index);
    }
    const auto stop =
        StopOf(configuration.trials.trials, crashed_bins, configuration.spec.stop_width);
    if (stop) {
      run.stops.push_back(
          fmt::format("{} {}.", stored.name.empty() ? run.name : stored.name, StopText(*stop)));
    }
    run.configurations.push_back(std::move(configuration));
  }
  CheckInput(!run.configurations.empty(),
             fmt::format("{} has no finished trial; resume the run to finish it", folder.string()));
  for (const CrashedTrial& crashed : all_crashed) run.crashed.push_back(crashed.trial);
  return run;
}

std::string RunReportPage(ReportRun run, const ObjectCatalog& catalog,
                          const ReportOptions& options) {
  const std::string cell_errors = CellErrorsText(run);  // before its trials are moved
  const AllConfigurations all = AllConfigurationsOf({&run});
  ReportContents contents;
  contents.title = fmt::format("Pick report: {}", run.name);
  if (run.configurations.size() == 1) {
    contents.about.push_back(SettingsText(run.configurations[0].spec, catalog));
  } else {
    contents.about.push_back(cell_errors);
  }
  contents.about.push_back(CrashedText(run));
  contents.about.insert(contents.about.end(), run.stops.begin(), run.stops.end());
  for (const ConfigurationComparison& comparison : CompareWithFirst(PairedConfigurationsOf(all))) {
    contents.comparisons.push_back(PairedReport(comparison));
  }
  return PageOf(all, std::move(contents), catalog, options);
}

RunComparison CompareRuns(ReportRun a, ReportRun b, const ObjectCatalog& catalog,
                          const ReportOptions& options) {
  CheckInput(a.name != b.name, fmt::format("{} is named twice; name two runs", a.name));
  const std::vector<PointPair> pairs = PairsOf(a, b);
  ReportContents contents;
  contents.different_settings = DifferentSettingsOf(a, b, pairs);
  const AllConfigurations all = AllConfigurationsOf({&a, &b});
  const std::vector<PairedConfiguration> configurations = PairedConfigurationsOf(all);
  contents.title = fmt::format("{} compared with {}", b.name, a.name);
  for (const ReportRun* run : {&a, &b}) {
    if (run->configurations.size() == 1) {
      contents.about.push_back(
          fmt::format("{}: {}", run->name, SettingsText(run->configurations[0].spec, catalog)));
    }
    contents.about.push_back(CrashedText(*run));
    contents.about.insert(contents.about.end(), run->stops.begin(), run->stops.end());
  }
  RunComparison result;
  for (const PointPair& pair : pairs) {
    const PairedConfiguration &before = configurations[pair.a],
                              &after = configurations[a.configurations.size() + pair.b];
    RequireSameScenes(before.identity, after.identity, before.trials->name, after.trials->name);
    result.configurations.push_back(CompareConfigurations(before, after));
    contents.comparisons.push_back(PairedReport(result.configurations.back()));
  }
  result.page = PageOf(all, std::move(contents), catalog, options);
  return result;
}

}  // namespace pickbed::eval
