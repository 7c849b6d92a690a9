#include "eval/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "eval/paired_comparison.h"
#include "eval/pictures.h"
#include "eval/report_views.h"
#include "eval/results_store.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/image_io.h"

namespace pickbed {
namespace {

namespace fs = std::filesystem;

constexpr double kMegabyte = 1e6;
constexpr double kBase64 = 4.0 / 3;  // growth of bytes that stand in text

std::string AddressOf(const ReportRun& run, int trial) {
  return fmt::format("{}#{}", run.name, trial);
}

// Empty where the run has no picture of it.
std::string PictureOf(const ReportRun& run, const LostPick& pick, const ReportOptions& options) {
  const fs::path folder = run.folder / "pictures" / fmt::format("trial_{:04}", pick.trial);
  const fs::path small = folder / LostPictureName(pick.pick);
  if (fs::is_regular_file(small)) return ReadFileBytes(small);
  const fs::path file = folder / fmt::format("pick_{:02}_overlay.png", pick.pick);
  if (!fs::is_regular_file(file)) return "";
  return EncodeJpeg(Narrowed(ReadPng(file), options.picture_width_px), options.picture_quality);
}

// Points of all runs in one list, with names that tell them apart.
struct Contestants {
  std::vector<const ReportRun*> runs;
  std::vector<const ReportPoint*> points;
  std::vector<PointTrials> trials;  // taken out of the runs: they may be many
};

Contestants PointsOf(const std::vector<ReportRun*>& runs) {
  Contestants all;
  for (ReportRun* run : runs) {
    for (ReportPoint& point : run->points) {
      all.runs.push_back(run);
      all.points.push_back(&point);
      PointTrials& trials = all.trials.emplace_back(std::move(point.trials));
      if (runs.size() > 1 || trials.name.empty()) {
        trials.name =
            run->points.size() > 1 ? fmt::format("{}: {}", run->name, trials.name) : run->name;
      }
    }
  }
  return all;
}

void AddGallery(const Contestants& all, const ReportOptions& options, ReportContents& contents) {
  const std::vector<LostPick> lost = LostPicksOf(all.trials);
  contents.lost = static_cast<int>(lost.size());
  double bytes = 0;
  int without = 0;
  for (const LostPick& pick : SpreadOverReasons(lost, options.failures)) {
    const ReportRun& run = *all.runs[pick.point];
    GalleryEntry& entry = contents.gallery.emplace_back();
    entry.pick = pick;
    entry.address = AddressOf(run, pick.trial);
    if (bytes < options.pictures_mb * kMegabyte) entry.jpeg = PictureOf(run, pick, options);
    bytes += kBase64 * entry.jpeg.size();
    without += entry.jpeg.empty();
  }
  const size_t shown = contents.gallery.size();
  if (shown < lost.size()) {
    contents.gallery_note = fmt::format(
        "{} of {} lost picks, spread over the reasons; picks.csv lists all.", shown, lost.size());
  }
  if (without > 0) {
    contents.gallery_note += fmt::format(
        "{}{} have no picture here: a run draws them up to a number of trials (`pickbed run "
        "--lost-pictures N`), and a page holds {:.0f} MB of them.",
        contents.gallery_note.empty() ? "" : " ",
        without == static_cast<int>(shown) ? "They" : fmt::format("{}", without),
        options.pictures_mb);
  }
}

std::string ViewTitle(const Contestants& all, const ViewChoice& choice) {
  const PointTrials& point = all.trials[choice.point];
  const PickRecord& pick = point.trials[choice.trial].picks[choice.look];
  const std::string outcome =
      pick.loss == Loss::kNone ? "picked" : fmt::format("lost: {}", LossName(pick.loss));
  const std::vector<VisibleBand>& bands = all.points[choice.point]->spec.occlusion.bands;
  const std::string title =
      pick.band >= 0 ? fmt::format("{} % in view, {}", bands.at(pick.band).name(), outcome)
                     : fmt::format("look {}, {}", pick.pick, outcome);
  return all.trials.size() > 1 ? fmt::format("{}, {}", point.name, title) : title;
}

void AddViews(const Contestants& all, const ObjectCatalog& catalog, const ReportOptions& options,
              ReportContents& contents) {
  std::map<size_t, std::unique_ptr<ViewMaker>> makers;  // by point
  double bytes = 0;
  try {
    for (const ViewChoice& choice : ChooseViews(all.trials, options.views)) {
      const ScenarioSpec& spec = all.points[choice.point]->spec;
      std::unique_ptr<ViewMaker>& maker = makers[choice.point];
      if (!maker) {
        maker = std::make_unique<ViewMaker>(spec, LoadObjects(spec, catalog), options);
      }
      const TrialResult& trial = all.trials[choice.point].trials[choice.trial];
      ReportView view{ViewTitle(all, choice), AddressOf(*all.runs[choice.point], trial.trial),
                      maker->Glb(trial, choice.look)};
      bytes += kBase64 * view.glb.size();
      if (bytes > options.views_mb * kMegabyte) {
        contents.views_note +=
            fmt::format(" More are left out: a page holds {:.0f} MB of them.", options.views_mb);
        return;
      }
      contents.views.push_back(std::move(view));
      contents.views_note = "Some looks: drag to turn, wheel or two fingers to come near.";
    }
  } catch (const InputError& error) {
    contents.views_note = fmt::format("Views in 3D are left out: {}.", error.what());
  }
}

std::string PageOf(const Contestants& all, ReportContents contents, const ObjectCatalog& catalog,
                   const ReportOptions& options) {
  contents.points = ReportOn(all.trials, options);
  AddGallery(all, options, contents);
  AddViews(all, catalog, options, contents);
  return ReportPage(contents);
}

std::string SettingsText(const ScenarioSpec& spec) {
  std::string parts;
  for (const PartSpec& part : spec.objects) {
    parts += fmt::format("{}{} {}", parts.empty() ? "" : ", ", part.count, part.name);
  }
  return fmt::format("Bins of {}; sensor {}, estimator {} ({}), refiner {}, gripper {}, seed {}.",
                     parts, spec.sensor, spec.estimator.name, spec.estimator.mode, spec.refiner,
                     spec.gripper, spec.seed);
}

// Scenarios of plain runs stand beside their store, where one may have changed what their results
// do not depend on.
ScenarioSpec SpecOf(const StoredPoint& point, size_t points, const fs::path& folder) {
  const fs::path file = folder / "scenario.yaml";
  if (points == 1 && fs::is_regular_file(file)) return LoadScenario(file);
  return LoadScenarioText(point.settings, folder, (folder / "results.sqlite").string());
}

std::vector<PairedPoint> PairedPointsOf(const Contestants& all) {
  std::vector<PairedPoint> points;
  for (size_t i = 0; i < all.trials.size(); ++i) {
    points.push_back({&all.trials[i], all.points[i]->identity});
  }
  return points;
}

// Places of the points of two runs that are to be compared.
struct PointPair {
  size_t a = 0, b = 0;
};

std::vector<PointPair> PairsOf(const ReportRun& a, const ReportRun& b) {
  if (a.points.size() == 1 && b.points.size() == 1) return {{0, 0}};
  std::vector<PointPair> pairs;
  for (size_t i = 0; i < a.points.size(); ++i) {
    for (size_t k = 0; k < b.points.size(); ++k) {
      if (a.points[i].trials.name == b.points[k].trials.name) pairs.push_back({i, k});
    }
  }
  CheckInput(!pairs.empty(),
             fmt::format("{} and {} have no settings in common (points of their sweeps, by name), "
                         "so nothing is compared",
                         a.name, b.name));
  return pairs;
}

// Trials that ended their worker are in no rate.
std::string CrashedText(const ReportRun& run) {
  if (run.crashed.empty()) return "";
  return fmt::format("{}: {} trials crashed and count nowhere, the first is {}.", run.name,
                     run.crashed.size(), AddressOf(run, run.crashed.front()));
}

}  // namespace

ReportRun ReadReportRun(const fs::path& folder) {
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  ReportRun run{(folder / "").parent_path().string(), folder, {}, {}, {}};
  const std::vector<CrashedTrial> all_crashed = store.Crashed();
  for (const StoredPoint& stored : store.head().points) {
    ReportPoint point;
    point.trials.trials = store.Read(stored.first_trial, stored.first_trial + stored.trials);
    if (point.trials.trials.empty()) continue;
    point.spec = SpecOf(stored, store.head().points.size(), folder);
    point.identity = stored.identity;
    point.trials.name = stored.name;
    point.trials.cycle = point.spec.cycle;
    point.trials.bands = ReportedBands(point.spec.occlusion);
    for (const PartSpec& part : point.spec.objects) point.trials.objects.push_back(part.name);
    std::vector<int> crashed_scenes;
    for (const CrashedTrial& crashed : all_crashed) {
      if (crashed.point == stored.point) crashed_scenes.push_back(crashed.scene);
    }
    const auto stop = StopOf(point.trials.trials, crashed_scenes, point.spec.stop_width);
    if (stop) {
      run.stops.push_back(
          fmt::format("{} {}.", stored.name.empty() ? run.name : stored.name, StopText(*stop)));
    }
    run.points.push_back(std::move(point));
  }
  CheckInput(
      !run.points.empty(),
      fmt::format("{} holds no finished trial; finish the run with --resume", folder.string()));
  for (const CrashedTrial& crashed : all_crashed) run.crashed.push_back(crashed.trial);
  return run;
}

std::string RunReportPage(ReportRun run, const ObjectCatalog& catalog,
                          const ReportOptions& options) {
  const Contestants all = PointsOf({&run});
  ReportContents contents;
  contents.title = fmt::format("Pick report: {}", run.name);
  if (run.points.size() == 1) contents.about.push_back(SettingsText(run.points[0].spec));
  contents.about.push_back(CrashedText(run));
  contents.about.insert(contents.about.end(), run.stops.begin(), run.stops.end());
  for (const PointComparison& comparison : CompareWithFirst(PairedPointsOf(all))) {
    contents.comparisons.push_back(PairedReport(comparison));
  }
  return PageOf(all, std::move(contents), catalog, options);
}

RunComparison CompareRuns(ReportRun a, ReportRun b, const ObjectCatalog& catalog,
                          const ReportOptions& options) {
  CheckInput(a.name != b.name, fmt::format("{} is named twice; name two runs", a.name));
  const std::vector<PointPair> pairs = PairsOf(a, b);
  const Contestants all = PointsOf({&a, &b});
  const std::vector<PairedPoint> points = PairedPointsOf(all);
  ReportContents contents;
  contents.title = fmt::format("{} against {}", b.name, a.name);
  for (const ReportRun* run : {&a, &b}) {
    if (run->points.size() == 1) {
      contents.about.push_back(fmt::format("{}: {}", run->name, SettingsText(run->points[0].spec)));
    }
    contents.about.push_back(CrashedText(*run));
    contents.about.insert(contents.about.end(), run->stops.begin(), run->stops.end());
  }
  RunComparison result;
  for (const PointPair& pair : pairs) {
    const PairedPoint &before = points[pair.a], &after = points[a.points.size() + pair.b];
    RequireSameScenes(before.identity, after.identity, before.trials->name, after.trials->name);
    result.points.push_back(ComparePoints(before, after));
    contents.comparisons.push_back(PairedReport(result.points.back()));
  }
  result.page = PageOf(all, std::move(contents), catalog, options);
  return result;
}

}  // namespace pickbed
