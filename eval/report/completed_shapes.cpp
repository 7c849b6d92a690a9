#include "eval/report/completed_shapes.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/completion/draw.h"
#include "eval/draw/bin_view.h"
#include "eval/export/scene_glb.h"
#include "eval/page/html.h"
#include "eval/report/run_page.h"
#include "eval/segments/segmentation.h"
#include "eval/shapes/segment_shapes.h"
#include "eval/summary/result_files.h"
#include "eval/trial/attempt.h"
#include "eval/trial/trial.h"
#include "grasp/grippers/table.h"
#include "grasp/planners/table.h"
#include "perception/segments/object_segments.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/ids_format.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

// As many as the planner completes.
constexpr int kMaxShapes = 10;
// A cloud with more points makes a page slow.
constexpr int kCloudStride_px = 2;
constexpr int kSectionPixel = 4;  // of a cell in a slice

grasp::PlannerInput InputFor(const SimulatedCell& cell, const Observation& view) {
  const CellCalibration& calibration = view.calibration;
  return {view.frame, calibration.camera.X_WC(),
          grasp::BinPlacement{cell.bin(), calibration.X_WB.value_or(Pose::Identity())}};
}

// Means over blocks of cells, until there are at most kShownCells along each axis.
grasp::OccupancyShape Coarsened(grasp::OccupancyShape shape) {
  while (shape.size > CompletedShapes::kShownCells && shape.size % 2 == 0) {
    grasp::OccupancyShape half = shape;
    half.size = shape.size / 2;
    half.cell_m = 2 * shape.cell_m;
    half.occupancy.clear();
    for (int z = 0; z < half.size; ++z) {
      for (int y = 0; y < half.size; ++y) {
        for (int x = 0; x < half.size; ++x) {
          float sum = 0;
          for (int i = 0; i < 8; ++i) {
            sum += shape.At(2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2));
          }
          half.occupancy.push_back(sum / 8);
        }
      }
    }
    shape = std::move(half);
  }
  return shape;
}

// Returns the index along an axis of the slice with the largest sum of probabilities. The middle
// slice of the cube often misses a thin object.
int FullestSlice(const grasp::OccupancyShape& shape, int axis) {
  std::vector<double> sums(shape.size, 0);
  for (int z = 0; z < shape.size; ++z) {
    for (int y = 0; y < shape.size; ++y) {
      for (int x = 0; x < shape.size; ++x) {
        const int cell[3] = {x, y, z};
        sums[cell[axis]] += shape.At(x, y, z);
      }
    }
  }
  return static_cast<int>(std::ranges::max_element(sums) - sums.begin());
}

// Draws two slices of the cube: across the view and, beside it, along it. A slice shows that
// probabilities inside the outline are uncertain, too.
Image<Rgb8> ProbabilityPicture(const grasp::OccupancyShape& shape) {
  const int n = shape.size;
  const int across_z = FullestSlice(shape, 2), along_x = FullestSlice(shape, 0);
  constexpr int kGap = 2;  // cells
  Image<Rgb8> picture(kSectionPixel * (2 * n + kGap), kSectionPixel * n, {255, 255, 255});
  for (int row = 0; row < picture.height(); ++row) {
    for (int column = 0; column < picture.width(); ++column) {
      const int x = column / kSectionPixel, y = row / kSectionPixel;
      const bool from_side = x >= n + kGap;
      if (x >= n && !from_side) continue;
      const float p = from_side ? shape.At(along_x, y, x - n - kGap) : shape.At(x, y, across_z);
      const auto shade = static_cast<uint8_t>(255 - 215 * p);
      picture(column, row) = {shade, static_cast<uint8_t>(255 - 150 * p), 255};
    }
  }
  return picture;
}

std::string PickText(const std::optional<Grasp>& chosen, const AttemptRecord& record) {
  if (!chosen) return "The planner found no grasp.";
  return fmt::format(
      "The best grasp has score {:.2f} and opens {:.0f} mm. In the simulation it {}.",
      chosen->score, 1000 * chosen->width_m,
      record.failure == FailureReason::kNone
          ? std::string("picks an object")
          : fmt::format("fails: {}", FailureName(record.failure)));
}

}  // namespace

CompletedShapes::CompletedShapes(const ScenarioSpec& spec) {
  const grasp::PlannerRow& row = grasp::PlannerNamed(spec.planner.name);
  if (!row.needs_shapes) return;
  shapes_ = std::make_unique<SegmentShapes>(
      spec.planner.segmentation,
      row.completion != nullptr ? row.completion : spec.planner.completion);
}

CompletedShapes::~CompletedShapes() = default;

std::vector<grasp::OccupancyShape> CompletedShapes::Of(const SimulatedCell& cell,
                                                       const Scene& scene, const ObjectSet& objects,
                                                       const Observation& view) const {
  if (!shapes_) return {};
  const TrueShapes truth{scene, objects, view.ids};
  shapes_->SetTruth(&truth);
  std::vector<grasp::OccupancyShape> shapes = shapes_->Shapes(InputFor(cell, view), kMaxShapes);
  shapes_->SetTruth(nullptr);
  for (grasp::OccupancyShape& shape : shapes) shape = Coarsened(std::move(shape));
  return shapes;
}

bool CompletesShapes(const std::string& planner) {
  return grasp::PlannerNamed(planner).needs_shapes;
}

ExplanationPage ExplainUnknown(const ScenarioSpec& spec, const ObjectSet& objects,
                               const std::string& title, BinIndex bin_index,
                               const std::filesystem::path& folder) {
  CheckInput(CompletesShapes(spec.planner.name),
             fmt::format("planner {} completes no shapes; explain its estimator instead",
                         spec.planner.name));
  TrialSetup setup(spec, objects, {}, {});
  PickingTrial trial(setup, bin_index);
  CheckInput(!trial.HasEnded(), fmt::format("bin {} is empty; choose another trial", bin_index));
  const Scene scene = trial.scene();
  LiveAttempt& attempt = trial.Attempt();
  attempt.Estimate();
  const std::optional<Grasp> chosen = attempt.ChooseGrasp();
  const Observation view = attempt.image()->view;
  const ObjectSet true_objects = setup.cell.TrueObjects(bin_index);
  const std::vector<grasp::OccupancyShape> shapes =
      CompletedShapes(spec).Of(setup.cell, scene, true_objects, view);
  const AttemptRecord record = trial.Execute(chosen);

  const std::string image = TrialImageName(bin_index);
  const std::filesystem::path pictures = std::filesystem::path(kPicturesFolder) / image;
  MakeFolder(folder / pictures);
  HtmlPage page(title);
  page.Paragraph(PickText(chosen, record));
  page.Heading("Segments");
  page.Paragraph("Each color is a segment, found without any object model.");
  const perception::ObjectSegments segments =
      perception::SegmentFrame(view.frame, view.calibration.Background(setup.cell.bin()),
                               perception::SegmenterNamed(spec.planner.segmentation).options());
  const ImageBox region = BinRegion(setup.cell.camera(), setup.cell.bin());
  const std::filesystem::path segments_file = pictures / "segments.png";
  WritePng(folder / segments_file,
           Cropped(SegmentOverlay(view.frame.color, segments.labels), region));
  page.WidePicture(segments_file.string(), fmt::format("{} segments", segments.segments.size()));
  page.Heading("Completed shapes");
  page.Paragraph(
      "Two slices of each completed cube, across the view and along it, where the most matter is. "
      "Dark cells are probably inside the object, light ones possibly. The highest segment is "
      "first.");
  for (size_t i = 0; i < shapes.size(); ++i) {
    const std::filesystem::path file = pictures / fmt::format("shape_{:02}.png", i);
    WritePng(folder / file, ProbabilityPicture(shapes[i]));
    page.Picture(file.string(), fmt::format("segment {}", i + 1));
  }
  page.Heading("In 3D");
  page.Note(
      "Each completed segment has a color, another one than in the picture above. The planner "
      "grasps its opaque surface, at a probability of 0.45, and keeps hands out of the transparent "
      "one, at 0.3. True objects are gray.");
  const GlbCloud cloud = ObservedCloud(view.frame, view.calibration.camera.X_WC(), kCloudStride_px);
  const std::string glb =
      SceneGlb({.scene = scene,
                .objects = setup.cell.objects(),
                .hypotheses = {},
                .grasp = chosen ? &*chosen : nullptr,
                .gripper = &ToolNamed(setup.tools, chosen ? chosen->tool : std::string()),
                .cloud = &cloud,
                .true_objects = &true_objects,
                .completed = shapes});
  page.Html("<div class=\"views screen\">\n" + ViewHtml({"first pick", image, glb}) + "</div>\n");
  ExplanationPage written;
  written.file = folder / ExplainPageName(image);
  written.replaced = std::filesystem::exists(written.file);
  written.unwritten = WritePage(written.file, page);
  return written;
}

}  // namespace pickbed::eval
