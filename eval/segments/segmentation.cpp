#include "eval/segments/segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "eval/cell/simulated_cell.h"
#include "eval/draw/canvas.h"
#include "eval/draw/overlay.h"
#include "eval/segments/labelled_cloud.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

// An image with its labels.
struct LabelledImage {
  std::string name;
  RgbdFrame frame;
  std::optional<KnownBackground> background;
  Image<uint16_t> truth;
  std::vector<int> hidden;  // labels of instances that do not count for recall
};

class Runner {
 public:
  explicit Runner(const SegmentationOptions& options) : options_(options) {
    if (options.methods.empty()) {
      for (const auto& row : perception::SegmenterTable()) rows_.push_back({row.name, {}});
    }
    for (const std::string& name : options.methods) {
      CheckInput(std::ranges::count(options.methods, name) == 1,
                 fmt::format("method '{}' is given twice; give it once", name));
      rows_.push_back({perception::SegmenterNamed(name).name, {}});
    }
    if (!options.pictures.empty()) MakeFolder(options.pictures);
  }

  void Add(const LabelledImage& image) {
    std::vector<Image<Rgb8>> tiles;
    std::vector<std::string> captions;
    const bool is_pictured = !options_.pictures.empty() && images_ < options_.pictured_images;
    const Image<Rgb8> picture = is_pictured ? VisibleImage(image.frame) : Image<Rgb8>();
    const auto add_tile = [&](const Image<uint16_t>& labels, const std::string& caption) {
      if (!is_pictured) return;
      tiles.push_back(SegmentOverlay(picture, labels));
      captions.push_back(caption);
    };
    add_tile(image.truth, "truth");
    for (SegmentationRow& row : rows_) {
      const perception::SegmenterOptions options = perception::SegmenterNamed(row.method).options();
      const auto start = std::chrono::steady_clock::now();
      const perception::ObjectSegments found =
          perception::SegmentFrame(image.frame, image.background, options);
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
      SegmentScores scores = ScoreSegments(found.labels, image.truth);
      for (SegmentedInstance& instance : scores.instances) {
        instance.is_counted = std::find(image.hidden.begin(), image.hidden.end(), instance.label) ==
                              image.hidden.end();
      }
      add_tile(found.labels, fmt::format("{}: {} segments", row.method, found.segments.size()));
      row.images.push_back({image.name, std::move(scores), seconds.count()});
    }
    if (is_pictured) {
      WritePng(options_.pictures / fmt::format("{}.png", image.name),
               ContactSheet(tiles, captions, 2));
    }
    ++images_;
  }

  std::vector<SegmentationRow> Take() { return std::move(rows_); }

 private:
  const SegmentationOptions& options_;
  std::vector<SegmentationRow> rows_;
  int images_ = 0;
};

void RemoveUnmeasured(const Image<float>& depth_m, Image<uint16_t>& labels) {
  for (size_t i = 0; i < labels.size(); ++i) {
    if (!(depth_m.data()[i] > 0)) labels.data()[i] = 0;
  }
}

}  // namespace

std::vector<SegmentationRow> SegmentBins(const ScenarioSpec& spec, const ObjectSet& objects,
                                         const SegmentationOptions& options,
                                         const SegmentationProgress& on_image) {
  SimulatedCell cell(spec, objects);
  Runner runner(options);  // makes the folder, so bad arguments are refused before
  for (int trial = 0; trial < spec.trials; ++trial) {
    const BinIndex bin_index(trial);
    const Scene scene = cell.MakeScene(bin_index).scene;
    Observation view = cell.Capture(scene, bin_index, 0);
    LabelledImage image{fmt::format("trial_{:04}", trial),
                        std::move(view.frame),
                        view.calibration.Background(cell.bin()),
                        std::move(view.ids),
                        {}};
    RemoveUnmeasured(image.frame.depth_m, image.truth);
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      if (view.visible_fractions[i] < kHalfVisible) {
        image.hidden.push_back(scene.objects[i].instance + 1);
      }
    }
    runner.Add(image);
    if (!on_image(trial + 1, spec.trials)) break;
  }
  return runner.Take();
}

std::vector<SegmentationRow> SegmentClouds(const std::filesystem::path& folder,
                                           const SegmentationOptions& options,
                                           const SegmentationProgress& on_image) {
  const std::vector<std::string> names = StemsIn(folder, ".pcd");
  CheckInput(!names.empty(),
             fmt::format("{}: no *.pcd file; give a folder of labelled clouds", folder.string()));
  Runner runner(options);
  for (size_t i = 0; i < names.size(); ++i) {
    LabelledCloud cloud = ReadLabelledCloud(folder / (names[i] + ".pcd"));
    for (uint16_t& label : cloud.labels.pixels()) {
      if (label <= options.background_label) label = 0;
    }
    RemoveUnmeasured(cloud.frame.depth_m, cloud.labels);
    runner.Add({names[i], std::move(cloud.frame), std::nullopt, std::move(cloud.labels), {}});
    if (!on_image(static_cast<int>(i) + 1, static_cast<int>(names.size()))) break;
  }
  return runner.Take();
}

Image<Rgb8> SegmentOverlay(const Image<Rgb8>& picture, const Image<uint16_t>& labels) {
  constexpr double kOpacity = 0.55;
  Image<Rgb8> overlay = picture;
  const Image<Rgb8> colors = ColorizeIds(labels);
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      const uint16_t label = labels(x, y);
      const bool is_border =
          (x > 0 && labels(x - 1, y) != label) || (y > 0 && labels(x, y - 1) != label);
      if (is_border) {
        overlay(x, y) = {255, 255, 255};
      } else if (label > 0) {
        overlay(x, y) = Mixed(picture(x, y), colors(x, y), kOpacity);
      }
    }
  }
  return overlay;
}

}  // namespace pickbed::eval
