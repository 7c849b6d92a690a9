// Pages of the result files: every file that a command writes, with its columns or keys.

#include <fmt/format.h>

#include "eval/benchmark/bins.h"
#include "eval/benchmark/completed_grasps.h"
#include "eval/benchmark/crops_report.h"
#include "eval/benchmark/recognition.h"
#include "eval/benchmark/rooms.h"
#include "eval/benchmark/rooms_poses.h"
#include "eval/bop/layout.h"
#include "eval/bop/results_csv.h"
#include "eval/budget/report.h"
#include "eval/calibrate/report.h"
#include "eval/compare/paired_tables.h"
#include "eval/completion/benchmark_report.h"
#include "eval/completion/training_page.h"
#include "eval/draw/grasp_sheet.h"
#include "eval/draw/object_sheet.h"
#include "eval/estimate/image_poses.h"
#include "eval/estimate/report.h"
#include "eval/execution/execution.h"
#include "eval/execution/report.h"
#include "eval/explain/explain.h"
#include "eval/export/grasps_csv.h"
#include "eval/export/made_object_json.h"
#include "eval/export/scene_json.h"
#include "eval/export/visibility_csv.h"
#include "eval/frames/image_notes.h"
#include "eval/grasps/report.h"
#include "eval/page/html.h"
#include "eval/reference/markdown.h"
#include "eval/reference/pages.h"
#include "eval/replay/replay.h"
#include "eval/segments/segmentation.h"
#include "eval/store/results_store.h"
#include "eval/store/store_columns.h"
#include "eval/summary/clutter_json.h"
#include "eval/summary/result_files.h"
#include "eval/summary/run_columns.h"
#include "eval/tolerance/maps.h"
#include "eval/tolerance/pick_forecast.h"
#include "eval/tolerance/report.h"
#include "eval/tolerance/samples.h"
#include "eval/train/page.h"
#include "grasp/tolerance/tolerance_model.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::eval {
namespace {

constexpr char kColumn[] = "column";
constexpr char kKey[] = "key";
constexpr char kIntervals[] =
    "Intervals are 95 % intervals, given as `[low, high]`. Bins are the independent units.";

ResultFile Csv(const std::string& name, const std::string& help, const ResultColumns& columns) {
  return {name, help, kColumn, columns};
}
ResultFile Json(const std::string& name, const std::string& help, const ResultColumns& keys) {
  return {name, help, kKey, keys};
}
ResultFile Plain(const std::string& name, const std::string& help) { return {name, help, "", {}}; }

ResultPage RunPage() {
  return {
      "files.md",
      "Result files of runs and sweeps",
      {{"Results folder of a run or sweep",
        fmt::format("Written by `pickbed run`, `sweep` and `merge`. Only `{}` and the store have "
                    "times; the same settings give the same bytes in all other files. {} More "
                    "files: [tables of {}](files_store.md), [budget, comparison and "
                    "estimate](files_measurements.md), [tolerance maps and "
                    "benchmarks](files_benchmark.md), [benchmark of "
                    "completion](files_completion.md), [scenes and objects](files_objects.md), "
                    "[trained models](files_models.md), [datasets](files_datasets.md).",
                    kTimingsFile, kIntervals, kStoreFile),
        {Plain(kStoreFile,
               "all results, as an SQLite database; the other files are computed from "
               "it"),
         Plain(kScenarioFile, "effective settings of a run"),
         Plain(kSweepFile, "settings of a sweep"),
         Plain(fmt::format("{}/*.yaml", kConfigurationsFolder),
               "effective settings of each configuration of a sweep"),
         Plain(fmt::format("{}/trial_NNNN/*", kPicturesFolder),
               "pictures of attempts: color, depth, overlay of the poses, after the pick, failed; "
               "animation of the pick or stir"),
         Plain(fmt::format("{}/{}", kPicturesFolder, kOcclusionSheet),
               "one target in all bands, of occlusion trials"),
         Plain(fmt::format("{}/{}", kPicturesFolder, kHiddenShareSheet),
               "targets picked by hidden share over published curves, of occlusion trials"),
         Plain(fmt::format("{}/*", kShardsFolder), "results folders of the shards of a sweep"),
         Plain(fmt::format("{}/*", kSlurmFolder), "job script and logs of the shards"),
         Plain(fmt::format("{}/*", kLogsFolder),
               "standard error of estimators and planners that are other programs"),
         Plain(kImageFolderFile, "path of the dataset of `--bop-out`"),
         Plain(kReportFile, "page of `pickbed report`"),
         Plain(fmt::format("{}, {}", kCalibrationFile, kCalibrationPage),
               "calibration and page of `pickbed calibrate`, see [calibration "
               "file](settings_files.md#calibration-file)"),
         Csv(kTrialsFile, "one line per trial", TrialsColumns()),
         Csv(kAttemptsFile, "one line per attempt", AttemptsColumns()),
         Csv(kInstancesFile, "one line per instance in view of each image", InstancesColumns()),
         Csv(kInstanceOutcomesFile, "one line per dropped instance that is not a distractor",
             InstanceOutcomesColumns()),
         Csv(kConfigurationsFile, "one line per configuration", ConfigurationsColumns()),
         Csv(kTimingsFile, "durations by trial and stage", TimingsColumns()),
         Csv(kCurveFile, "only of occlusion trials: one line per configuration and band",
             CurveColumns()),
         Csv(kHiddenShareFile,
             "only of occlusion trials: one line per configuration and band of the hidden share, "
             "with published curves",
             HiddenShareColumns()),
         Csv(kPickChancesFile, "only with --tolerance: one line per reported pose",
             PickChancesColumns()),
         Plain(kSummaryFile,
               fmt::format("statistics, see [{}](files_summary.md)", kSummaryFile))}}}};
}

ResultPage SummaryPage() {
  return {"files_summary.md",
          fmt::format("Keys of {}", kSummaryFile),
          {{"Statistics of a run or sweep",
            fmt::format("`{}` in a results folder. {} With too few bins an interval is null, and a "
                        "key that ends with `_missing` has the reason.",
                        kSummaryFile, kIntervals),
            {Json(kSummaryFile,
                  "statistics of a run; of a sweep, `configurations[]` has `configuration`, `name` "
                  "and the same keys",
                  SummaryKeys())}}}};
}

ResultPage StorePage() {
  ResultFolder folder{
      "Tables",
      fmt::format(
          "`{0}` in a results folder has these tables. Read it with any SQLite program, for "
          "example `sqlite3 results/demo/{0} \"SELECT failure, count(*) FROM attempts GROUP "
          "BY failure\"`. A later version of pickbed migrates the file of an earlier one.",
          kStoreFile),
      {}};
  for (const StoreTable& table : StoreTables()) {
    folder.files.push_back({table.name, table.help, kColumn, table.columns});
  }
  return {"files_store.md", fmt::format("Tables of {}", kStoreFile), {folder}};
}

ResultColumns ModelKeys() {
  ToleranceModel model;
  ResultColumns keys;
  for (const SettingRow& row : SettingRows([&](SettingsVisitor& v) { model.Visit(v); })) {
    if (row.value != "list") keys.push_back({row.key, row.help, row.unit});
  }
  return keys;
}

ResultPage MeasurementsPage() {
  return {
      "files_measurements.md",
      "Result files of budget, comparison and estimate",
      {{"pickbed budget",
        "Files in `RUN/budget`.",
        {Plain(kIndexPage, "page with charts"),
         Plain(fmt::format("{}, {}, {}", kAttemptsSheet, kInstancesSheet, kGainsSheet), "charts"),
         Plain("STAGE/*", "results folder of the rerun with ground truth for a stage"),
         Csv(kBudgetFile, "one line per rerun and reason", BudgetColumns()),
         Json(kBudgetJsonFile, "counts, shares and gains", BudgetKeys())}},
       {"pickbed compare",
        "The names are given by `--out` and `--json`.",
        {Plain(kComparisonPage, "both runs side by side"),
         Json("JSON file", "paired differences", ComparisonKeys())}},
       {"pickbed estimate",
        fmt::format("`--bop` writes only the results file and the list of its images. With "
                    "`--explain`, `{}` with its pictures.",
                    ExplainPageName("IMAGE")),
        {Plain(kComparisonPage, "page with charts and the first bins"),
         Csv(kComparisonFile, "one line per estimator, and one per estimator and object",
             EstimatorComparisonColumns()),
         Csv(kHypothesesFile, "one line per reported pose", HypothesesColumns()),
         Csv(kInstancesFile, "one line per estimator and instance in view of each image",
             EstimatedInstancesColumns()),
         Plain("ESTIMATOR_DATASET-SPLIT.partial.csv, ESTIMATOR_DATASET-SPLIT.partial.images.csv",
               "with --bop: both lists of the images that an interrupted run has finished"),
         Plain("ESTIMATOR_DATASET-SPLIT.partial.yaml",
               "settings and hashes of an interrupted run, for --resume"),
         Csv("ESTIMATOR_DATASET-SPLIT.csv", "with --bop: results in BOP's format",
             EstimateColumns()),
         Csv("ESTIMATOR_DATASET-SPLIT.images.csv", "with --bop: one line per image",
             DatasetImageColumns())}},
       {"pickbed estimate IMAGE",
        "Poses are in the camera frame.",
        {Plain(kOverlayFile, "the image with the outline and the score of each pose"),
         Csv(kPosesCsvFile, "one line per pose, highest score first", ImagePosesColumns()),
         Json(kPosesJsonFile, "the poses with the camera and the warnings", ImagePosesKeys())}}}};
}

ResultPage BenchmarkPage() {
  return {
      "files_benchmark.md",
      "Result files of tolerance maps and benchmarks",
      {{"pickbed tolerance",
        "Files of a tolerance map.",
        {Plain(kToleranceFile,
               "effective settings, see "
               "[tolerance map](settings_measurements.md#tolerance-map)"),
         Plain("map.png, pairs.png", "curves of the axes, and maps of pairs"),
         Csv(kSamplesFile, "one line per executed grasp, after a line that identifies the map",
             SamplesColumns()),
         Csv(kAxesFile, "success by error along each axis", AxesColumns()),
         Csv(kPairsFile, "with --pairs: success by errors along two axes", PairsColumns()),
         Csv(fmt::format("{}, {}", kPredictorsFile, kRunPredictorsFile),
             fmt::format("how well each score predicts success; {}: for the picks of --run",
                         kRunPredictorsFile),
             PredictorsColumns()),
         Json(kToleranceModelFile, "fitted model of the success probability", ModelKeys())}},
       {"pickbed benchmark",
        "`bins` and `crops` have a results folder each.",
        {Plain(fmt::format("{}, {}", kBinsPage, kCropsPage), "pages with charts"),
         Plain(kCropSettingsFile, "effective settings of the crop benchmark"),
         Plain("models/*", "trained models"),
         Plain("scenarios/*.json", "results of each scenario, from which `bins` continues"),
         Csv(kBinsFile, "one line per estimator over all scenarios, and one per scenario",
             BinTableColumns()),
         Csv(kCropsFile, "one line per method, stage, condition and object", CropTableColumns()),
         Csv(kCropViewsFile, "one line per test view, method and stage", CropViewsColumns()),
         Csv(kCropDifferencesFile, "paired differences of two methods", CropDifferencesColumns()),
         Csv(kTimingsFile, "durations", CropTimingsColumns()),
         Csv(kRoomsFile, "`rooms`: one line per kind of rooms and of background", RoomsColumns()),
         Csv(kRoomPosesFile, "`rooms`: one line per pose", RoomPosesColumns()),
         Plain("pictures/NUMBER_ROOMS_BACKGROUND.png", "`rooms`: images with a wrong pose")}}}};
}

ResultPage CompletionPage() {
  return {
      "files_completion.md",
      "Result files of the benchmark of completion",
      {{"pickbed benchmark completion",
        "One results folder.",
        {Plain(fmt::format("{}, gallery_SET.png", kIndexPage),
               "page with tables, and its pictures of completed shapes"),
         Plain("gallery_grasps_CONDITION_PLANNER.png", "pictures of grasps on the page"),
         Plain("recognition/SCENARIO_BIN/pictures/",
               "images and poses of recognition on the page, by trial and method"),
         Csv(kCompletionTable, "one line per method, set and condition", CompletionTableColumns()),
         Csv(kCompletionViews, "one line per method and view", CompletionViewsColumns()),
         Csv(kCompletionCalibration, "one line per method, set and bin of probability",
             CompletionCalibrationColumns()),
         Csv(kCompletionTimings, "durations", CompletionTimingsColumns()),
         Csv(kRecognitionFile,
             "recognition tables: one line per method, scenario and visible fraction",
             RecognitionColumns()),
         Csv(kRecognitionBinsFile,
             "recognition tables: one line per bin, method and visible fraction",
             RecognitionBinsColumns()),
         Csv(kCompletedGraspsFile, "grasp tables: one line per condition and planner",
             CompletedGraspsColumns()),
         Csv(kCompletedGraspsShapesFile, "grasp tables: one line per condition, planner and shape",
             CompletedGraspsShapesColumns())}}}};
}

ResultFolder DatasetFolder() {
  ResultFolder folder{
      "pickbed dataset make",
      "A dataset in BOP's layout, also from `pickbed run --bop-out`. Lengths are in mm where the "
      "unit is not in the key. `ID` is the number of an image or object.",
      {Plain(fmt::format("{}, {}", kCardTextFile, kDatasetSettingsFile),
             "the card as text, and its settings"),
       Plain(kDatasetScenarioFile, "the scenario of the stored scenes"),
       Plain("models/obj_NNNNNN.ply, models_eval/obj_NNNNNN.ply", "meshes"),
       Plain("SPLIT/SCENE/rgb, depth, mask, mask_visib",
             "images: color, depth, silhouettes and "
             "visible parts of instances")}};
  for (DatasetFile& file : DatasetFiles()) {
    folder.files.push_back(Json(file.name, file.help, file.keys));
  }
  return folder;
}

ResultFolder ExecutionFolder() {
  return {"pickbed execute",
          fmt::format("A results folder. The same inputs give the same bytes. {}", kIntervals),
          {Plain(kReportFile, "page with tables and charts"),
           Plain(kExecutionFile, "scenario, and hashes of all inputs"),
           Csv(kPicksFile, "one line per image, method and pick", PicksColumns()),
           Json(kExecutionSummaryFile, "statistics of the methods", ExecutionKeys())}};
}

ResultPage ObjectsPage() {
  return {"files_objects.md",
          "Result files of scenes and objects",
          {{"pickbed drop",
            "One settled scene.",
            {Plain("color.png", "camera image"),
             Json(kSceneFile, "bin and poses of the instances", SceneKeys()),
             Json(kCertificateFile, "proof that the scene is at rest", CertificateKeys()),
             Json(kClutterFile, "fill level, layers, visibility and graspable instances",
                  ClutterKeys())}},
           {"pickbed render",
            "One image.",
            {Plain("color.png", "camera image"),
             Plain("depth.png",
                   "depth along camera z with sensor noise, 16 bit, 0.1 mm per unit, 0 = "
                   "no reading"),
             Plain("ids.png", "instance + 1 at each pixel, 16 bit"),
             Plain("depth_color.png, ids_color.png", "the same in false colors"),
             Csv(kVisibilityFile, "one line per instance", VisibilityColumns())}},
           {"pickbed object add",
            "Folder of the object in the catalog.",
            {Plain(kObjectFile, "see [object file](settings_files.md#object-file)"),
             Plain("mesh.*, convex.obj", "mesh, and convex pieces for contact"),
             Plain(kObjectSheetFile, "picture of mesh, pieces, symmetries and resting poses"),
             Json(kMadeObjectFile, "inspection of the mesh, and quality of the pieces",
                  MadeObjectKeys())}},
           {"pickbed grasps",
            "Grasps of an object, best first.",
            {Plain(kGraspSheetFile, "picture of the best grasps"),
             Csv(kGraspsFile, "one line per grasp", GraspsColumns()),
             Csv(kGraspTestsFile, "with --from: one line per tested grasp", GraspTestsColumns())}},
           {"pickbed sensor, pickbed gripper",
            "The name is given by `--out`.",
            {Plain("sensor_NAME.png, gripper_NAME.png", "picture")}},
           {"pickbed segment",
            "One results folder.",
            {Plain("pictures/IMAGE.png", "overlays of the labels and of the segments"),
             Csv(kSegmentScoresFile, "one line per method and image", SegmentScoresColumns()),
             Csv(kSegmentsFile, "one line per method, image and instance", SegmentsColumns())}},
           {"pickbed replay",
            "Files of each stage of one trial.",
            {Plain("attempt_NN_{color,depth,ids,overlay,after}.png", "pictures"),
             Plain("attempt_NN_depth_16bit.png", "depth along camera z, 0.1 mm per unit"),
             Plain("attempt_NN_cloud.ply", "observed points in the world frame"),
             Plain("attempt_NN_hypotheses.ply", "surface points of the estimated poses"),
             Plain("attempt_NN_scene.glb", "true poses, estimated poses, hand and points"),
             Plain("attempt_NN_pick.{glb,gif}", "with --animate: animation of the pick or stir"),
             Csv(kStagesFile, "one line per stage of an attempt", ReplayColumns())}}}};
}

ResultPage ModelsPage() {
  return {
      "files_models.md",
      "Files of trained models",
      {{"pickbed train",
        "Model file, and a report folder beside it.",
        {Plain("MODEL.net", "trained model"),
         Plain("MODEL.net.checkpoint", "state of an interrupted training"),
         Plain(kIndexPage, "page with curves and pictures"),
         Csv(kCurvesFile, "one line per measurement of the held-out recall",
             CurvesColumns({"OBJECT"})),
         Csv(kTimingsFile, "durations", TrainingTimingsColumns())}},
       {"pickbed train verifier",
        "One file.",
        {Plain("FILE.net", "network for unknown backgrounds that objects share"),
         Plain("FILE.net.checkpoint", "candidates of an interrupted training")}},
       {"pickbed train completion",
        "Model file, and a report folder beside it.",
        {Plain("MODEL.net", "trained network"),
         Plain("MODEL.net.checkpoint", "state of an interrupted training"),
         Plain(fmt::format("{}, completions_SPLIT.png", kIndexPage),
               "page with curves, and its pictures"),
         Csv(kCompletionCurvesFile, "one line per measurement and held-out split",
             CompletionCurvesColumns())}},
       {"pickbed train grasps",
        "Model file, and a folder of executed grasps.",
        {Plain("MODEL.net", "trained network"),
         Plain("group_NNNN.grasps", "inputs and outcomes of the grasps of one group of bins")}}}};
}

// The list of files, then a table for each file with columns.
std::string FolderText(const ResultFolder& folder) {
  std::vector<std::vector<std::string>> rows{{"file", "content"}};
  std::string tables;
  for (const ResultFile& file : folder.files) {
    if (file.columns.empty()) {
      rows.push_back({MarkdownCode(file.name), file.help});
      continue;
    }
    tables += fmt::format("\n### {}\n\n{}.\n\n{}", file.name, file.help,
                          ColumnTable(file.column_title, file.columns));
  }
  std::string text = folder.intro + "\n";
  if (rows.size() > 1) text += "\n" + MarkdownTable(rows);
  return text + tables;
}

}  // namespace

std::vector<ResultPage> AllResultFiles() {
  return {RunPage(),
          SummaryPage(),
          StorePage(),
          MeasurementsPage(),
          BenchmarkPage(),
          CompletionPage(),
          ObjectsPage(),
          ModelsPage(),
          {"files_datasets.md",
           "Files of datasets and executed results",
           {DatasetFolder(), ExecutionFolder()}}};
}

void AddFilePages(Pages& pages) {
  for (const ResultPage& page : AllResultFiles()) {
    std::string& text = pages[page.file] = PageHead(page.title);
    for (const ResultFolder& folder : page.folders) {
      text += fmt::format("{}## {}\n\n{}", &folder == &page.folders.front() ? "" : "\n",
                          folder.title, FolderText(folder));
    }
  }
}

}  // namespace pickbed::eval
