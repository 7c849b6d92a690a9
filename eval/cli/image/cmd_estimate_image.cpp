#include "eval/cli/image/cmd_estimate_image.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "eval/bop/layout.h"
#include "eval/draw/overlay.h"
#include "eval/estimate/image_poses.h"
#include "eval/frames/frame_checks.h"
#include "eval/frames/frame_files.h"
#include "eval/frames/image_estimator.h"
#include "eval/frames/region.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/finite_counts.h"
#include "scenes/base/message_text.h"
#include "scenes/geometry/symmetry_finder.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_inspection.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::eval {
namespace {

// The physics is not used, so any mass will do.
constexpr double kAnyMass_kg = 0.1;

void Say(const std::string& line) { fmt::print(stderr, "pickbed: {}\n", line); }

std::shared_ptr<const ObjectModel> ObjectOfMesh(const std::string& mesh, const std::string& unit,
                                                std::vector<std::string>& notes) {
  const std::filesystem::path file = mesh;
  const InspectedMesh inspected = InspectMeshFile(file, unit, /*center=*/false);
  if (unit.empty()) {
    notes.push_back(
        fmt::format("{}: taken in {}; its diameter is then {:.1f} mm (--unit changes it)", mesh,
                    inspected.unit, 1e3 * Diameter(inspected.mesh_O)));
  }
  return LoadMeshObject(file.stem().string(), {.mesh = file,
                                               .unit = inspected.unit,
                                               .mass_kg = kAnyMass_kg,
                                               .symmetries_O = FindSymmetries(inspected.mesh_O)});
}

ObjectSet LoadImageObjects(const ImageArguments& image, const std::string& catalog_folder,
                           std::vector<std::string>& notes) {
  ObjectSet objects;
  for (const std::string& mesh : image.meshes) {
    objects.push_back(ObjectOfMesh(mesh, image.unit, notes));
  }
  const ObjectCatalog catalog = OpenCatalog(catalog_folder);
  for (const std::string& name : image.objects) objects.push_back(catalog.Load(name));
  CheckInput(!objects.empty(),
             "give the objects to search: --mesh FILE, or --object NAME of the catalog");
  for (size_t i = 0; i < objects.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      CheckInput(
          objects[i]->name != objects[k]->name,
          fmt::format("two objects have the name '{}'; give each object once, and other names "
                      "to the mesh files",
                      objects[i]->name));
    }
  }
  return objects;
}

// Returns the doubts about a frame and moves its color image to its depth. Throws InputError for
// the first error.
std::vector<std::string> Doubts(const ObjectSet& objects, const std::string& name,
                                FrameOfFiles& read) {
  std::vector<std::string> doubts;
  const std::vector<FrameFinding> findings = CheckFrame(read.frame, objects, read.depth_scale_mm);
  for (const FrameFinding& finding : findings) {
    CheckInput(!finding.is_error, name + ": " + finding.text);
    doubts.push_back(finding.text);
  }
  RegisterColor(findings, read.frame);
  return doubts;
}

InputError WithMeshHint(const InputError& error, const ImageArguments& image,
                        const EstimatorSpec& spec) {
  const std::string message = error.what();
  const bool is_untrained = message.find("not trained for object") != std::string::npos ||
                            message.find("has changed since training") != std::string::npos;
  if (!is_untrained || image.meshes.empty()) return error;
  const std::string mesh = image.meshes.front();
  const std::string name = std::filesystem::path(mesh).stem().string();
  // For ppf, only verifiers are trained, and only this mode uses them.
  const bool is_ppf = spec.name == "ppf";
  const std::string estimator = is_ppf ? "ppf:verified" : spec.name;
  const std::string train = is_ppf                      ? name + " --verifier-for ppf"
                            : spec.name == "descriptor" ? name
                                                        : spec.name + " " + name;
  return InputError(fmt::format(
      "{} knows no model of '{}'; use --estimator ppf, which needs no training, or run `pickbed "
      "object add {} --name {}` and `pickbed train {} --out models/{}.net`, and then give "
      "--object {} with --estimator {}=models/{}.net",
      estimator, mesh, mesh, name, train, name, name, estimator, name));
}

// Returns what to do if no pose was found. Empty if a lower limit of the score would not help.
std::string NoPoseHint(double min_score) {
  if (min_score <= 0) return "";
  constexpr double kLow = 0.1;
  return fmt::format(
      "no pose has a score of estimator.min_score = {:g} or more; lower it with --set "
      "estimator.min_score={:g}",
      min_score, min_score > kLow ? kLow : 0);
}

}  // namespace

void AddImageArguments(CLI::App& app, ImageArguments& image) {
  app.add_option("--depth", image.depth,
                 "depth image of IMAGE, registered to it: PNG, TIFF, OpenEXR or NumPy file, or an "
                 "organised cloud (PCD, PLY)");
  app.add_option(
      "--intrinsics", image.intrinsics,
      fmt::format("camera of IMAGE: FX,FY,CX,CY in px, or a file ({} of BOP, camera_info "
                  "of ROS, JSON of Open3D or RealSense, nine numbers); not needed for "
                  "clouds",
                  kDatasetCameraFile));
  app.add_option("--depth-scale", image.depth_scale_mm,
                 "length of one unit of the depth image, mm; default: 1 for integers, 1000 for "
                 "floats and clouds, or the value in the file of the intrinsics")
      ->check(CLI::Range(1e-6, 1e6));
  app.add_option("--mesh", image.meshes, "mesh of an object to search in IMAGE; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--unit", image.unit,
                 "unit of the meshes of --mesh; default: guessed from their size")
      ->check(CLI::IsMember({"m", "cm", "mm", "in"}));
  app.add_option("--object", image.objects,
                 "object of the catalog to search in IMAGE; may be repeated")
      ->allow_extra_args(false);
}

bool IsImage(const ScenarioRequest& arguments, const ImageArguments& image) {
  return IsFrameFile(arguments.scenario) || !image.depth.empty() || !image.meshes.empty();
}

int EstimateImage(const ScenarioRequest& arguments, const ImageArguments& image,
                  const EstimatorSpec& estimator, const ScenarioSpec& settings,
                  const std::string& roi, const std::string& out, int threads) {
  const std::filesystem::path file = arguments.scenario;
  CheckInput(!arguments.trials, "--trials applies to a SCENARIO; remove it for an image");
  FrameOfFiles read = ReadFrameFiles({file, image.depth, image.intrinsics, image.depth_scale_mm});
  std::vector<std::string> notes = read.notes;
  const ObjectSet objects = LoadImageObjects(image, arguments.catalog, notes);
  const std::string depth_name = image.depth.empty() ? file.string() : image.depth;
  ImageFacts facts{file.string(),
                   image.depth,
                   read.frame.intrinsics,
                   read.depth_scale_mm,
                   estimator.name + ":" + estimator.mode,
                   roi,
                   Doubts(objects, depth_name, read),
                   estimator.min_score,
                   estimator.model,
                   settings.refiner,
                   settings.seed};
  const RegionSpec region_spec = roi.empty() ? settings.roi : ParseRegion(roi);
  std::optional<ImageRegion> region;
  if (!region_spec.empty()) {
    region = MakeRegion(region_spec, read.frame, std::nullopt, objects);
    RequireReadingsIn(*region, read.frame, roi.empty() ? "roi" : roi);
  }
  const std::filesystem::path folder = OutFolder(out, file.stem().string(), "-estimate");
  MakeFolder(folder);

  EstimateResult result;
  std::string hint;
  {
    ProgressLine progress;
    ImageEstimatorSetup setup{objects, estimator, settings.refiner, threads, folder / kLogsFolder};
    setup.on_progress = [&](std::string_view what, double share) {
      progress.Show(fmt::format("{}: {}", what, WholePercentText(share)));
    };
    std::optional<ImageEstimator> runner;
    try {
      runner.emplace(setup, read.frame);
    } catch (const InputError& error) {
      throw WithMeshHint(error, image, estimator);
    }
    for (const std::string& note : notes) progress.Note(note);
    progress.Show("estimate ...");
    EstimatorInput input{read.frame, std::nullopt};
    input.is_first = true;
    if (region) input.region = &region->pixels;
    Rng rng = Rng::Derive(settings.seed, 0, "image/estimate");
    result = runner->Estimate(input, rng);
    if (result.hypotheses.empty() && !result.failure) hint = NoPoseHint(estimator.min_score);
    if (region) KeepPosesIn(*region, read.frame.intrinsics, objects, result.hypotheses);
  }
  if (result.failure) facts.warnings.push_back(result.failure->text);
  facts.warnings.insert(facts.warnings.end(), result.domain_warnings.begin(),
                        result.domain_warnings.end());
  if (!result.has_background) {
    facts.warnings.push_back(
        "no table, floor or bin was recognised: poses on it may have high scores");
  }
  for (std::string& line : NotFiniteWarnings()) facts.warnings.push_back(std::move(line));
  for (const std::string& warning : facts.warnings) Say(warning);
  if (!hint.empty()) Say(hint);

  const Image<Rgb8> picture = VisibleImage(read.frame);
  OverlayInput overlay{picture, read.frame.intrinsics, objects, {}};
  for (const PoseHypothesis& pose : result.hypotheses) {
    overlay.poses.push_back({pose.object, pose.X_CO, pose.score});
  }
  if (region) {
    overlay.region = &region->pixels;
    overlay.region_lines = region->BoxLines(read.frame.intrinsics);
  }
  WritePng(folder / kOverlayFile, DrawOverlay(overlay));
  WriteFileAtomically(folder / kPosesJsonFile, ImagePosesJson(facts, result.hypotheses, objects));
  WriteFileAtomically(folder / kPosesCsvFile, ImagePosesCsv(result.hypotheses, objects));
  for (const PoseHypothesis& pose : result.hypotheses) {
    const Eigen::Vector3d t_mm = 1e3 * pose.X_CO.translation();
    fmt::print("{} score {:.3f} at x {:.1f} y {:.1f} z {:.1f} mm\n", objects[pose.object]->name,
               pose.score, t_mm.x(), t_mm.y(), t_mm.z());
  }
  fmt::print("{}; {}, {} and {} in {}\n", Counted(result.hypotheses.size(), "pose"), kOverlayFile,
             kPosesJsonFile, kPosesCsvFile, folder.string());
  return 0;
}

}  // namespace pickbed::eval
