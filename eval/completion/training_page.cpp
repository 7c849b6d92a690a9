#include "eval/completion/training_page.h"

#include <fmt/format.h>

#include "eval/completion/draw.h"
#include "eval/page/vega.h"
#include "perception/completion/completion_file.h"
#include "perception/completion/network_completer.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

constexpr int kLossPoints = 60;
constexpr int kSheetViews = 12;  // of each split
constexpr int kSheetCells = 48;
constexpr uint64_t kSheetSeed = 7919;

ReportChart LossChart(const CompletionReport& report) {
  ValueCurve curve{"training", {}};
  const std::vector<double>& losses = report.loss_history;
  const size_t count = std::min<size_t>(kLossPoints, losses.size());
  for (size_t i = 0; i < count; ++i) {
    const size_t begin = i * losses.size() / count, end = (i + 1) * losses.size() / count;
    double sum = 0;
    for (size_t k = begin; k < end; ++k) sum += losses[k];
    const double mean = sum / static_cast<double>(end - begin);
    curve.points.push_back({0.5 * static_cast<double>(begin + end), mean, mean, mean});
  }
  std::vector<ValueCurve> curves{curve};
  for (int split = 0; split < kHeldOutSplitCount; ++split) {
    ValueCurve& held_out = curves.emplace_back(ValueCurve{kHeldOutSplits[split], {}});
    for (const CompletionMeasurement& m : report.measurements) {
      const double loss = m.splits[split].loss;
      held_out.points.push_back({1.0 * m.step, loss, loss, loss});
    }
  }
  return ValueCurves({"loss", "Cross-entropy",
                      "Mean over points that are not known to be empty; training: mean of each "
                      "interval of steps.",
                      ""},
                     "step", "cross-entropy", curves);
}

ReportChart IouChart(const CompletionReport& report) {
  std::vector<ValueCurve> curves;
  for (int split = 0; split < kHeldOutSplitCount; ++split) {
    ValueCurve clean{std::string(kHeldOutSplits[split]) + " clean", {}};
    ValueCurve occluded{std::string(kHeldOutSplits[split]) + " occluded", {}};
    for (const CompletionMeasurement& m : report.measurements) {
      const CompletionQuality& q = m.splits[split];
      clean.points.push_back({1.0 * m.step, q.iou_clean, q.iou_clean, q.iou_clean});
      occluded.points.push_back({1.0 * m.step, q.iou_occluded, q.iou_occluded, q.iou_occluded});
    }
    curves.push_back(clean);
    curves.push_back(occluded);
  }
  return ValueCurves({"iou", "IoU on held-out views",
                      "Mean over views, on random points that are not known to be empty.", ""},
                     "step", "IoU", curves, /*y_max=*/1);
}

std::string CurvesCsv(const CompletionReport& report) {
  std::string csv = HeaderLine(CompletionCurvesColumns());
  for (const CompletionMeasurement& m : report.measurements) {
    for (int split = 0; split < kHeldOutSplitCount; ++split) {
      const CompletionQuality& q = m.splits[split];
      csv += fmt::format("{},{},{:.6f},{:.6f},{:.6f}\n", m.step, kHeldOutSplits[split], q.loss,
                         q.iou_clean, q.iou_occluded);
    }
  }
  return csv;
}

TableCells QualityTable(const CompletionReport& report) {
  TableCells table{{"held-out views", "cross-entropy", "IoU clean", "IoU occluded"}};
  const CompletionMeasurement& last = report.measurements.back();
  for (int split = 0; split < kHeldOutSplitCount; ++split) {
    const CompletionQuality& q = last.splits[split];
    table.push_back({kHeldOutSplits[split], fmt::format("{:.4f}", q.loss),
                     fmt::format("{:.3f}", q.iou_clean), fmt::format("{:.3f}", q.iou_occluded)});
  }
  return table;
}

// Draws input, completion and truth of new views of a split, clean and occluded in turn.
Image<Rgb8> Sheet(const CompletionTrainingPage& page, const CompletionNetwork& network,
                  ShapeSplit split, bool held_out) {
  std::vector<const ShapeFamilyRow*> families;
  for (const ShapeDomain domain : page.job.domains) {
    const auto some = ShapeFamiliesOf(domain, held_out);
    families.insert(families.end(), some.begin(), some.end());
  }
  if (families.empty()) return {};
  std::vector<CompletionTile> tiles;
  Rng rng = Rng::Derive(kSheetSeed, static_cast<uint64_t>(split) + 10 * held_out, "sheet");
  for (int i = 0; i < kSheetViews; ++i) {
    const ShapeFamilyRow& family = *families[i % families.size()];
    const auto solid = SolidOf(SampleShape(family, split, rng.Next()).solid);
    RandomViewOptions views = page.options.views;
    views.occluded_share = i % 2;
    const RandomView drawn = DrawView(*solid, page.job.sensors, views, rng);
    const CompletedVolume completed = CompleteWithNetwork(network, drawn.view, kSheetCells);
    tiles.push_back({family.name, drawn.view, completed, TrueVolume(*solid, drawn, completed)});
  }
  return DrawCompletions(tiles);
}

}  // namespace

ResultColumns CompletionCurvesColumns() {
  return {{"step", "number of training steps so far"},
          {"split", "held-out views: seen families, unseen sizes of them, or unseen families"},
          {"cross_entropy", "mean over points that are not known to be empty", "nats"},
          {"iou_clean", "mean IoU of views without an occluder, on points", "0..1"},
          {"iou_occluded", "mean IoU of views with an occluder, on points", "0..1"}};
}

std::string WriteCompletionTrainingPage(const std::filesystem::path& folder,
                                        const CompletionTrainingPage& page) {
  MakeFolder(folder);
  const CompletionModel model = LoadCompletionModel(page.model_file);
  HtmlPage html("Training of " + page.model_file.stem().string());
  html.Paragraph(fmt::format(
      "{} steps with {} samples each. Held-out views show shapes that no training sample shows: of "
      "the same families, of sizes that were left out, and of families that were left out.{}",
      page.report.steps, page.options.batch,
      page.report.stopped_early ? " The training ended when these views did not improve." : ""));
  html.Table(QualityTable(page.report));
  html.Heading("Curves");
  html.Charts({LossChart(page.report), IouChart(page.report)});
  struct Split {
    const char* name;
    const char* title;
    ShapeSplit split;
    bool held_out;
  };
  for (const Split& s : {Split{"seen", "Seen families", ShapeSplit::kSeen, false},
                         Split{"unseen_sizes", "Unseen sizes", ShapeSplit::kUnseenSizes, false},
                         Split{"outside", "Sizes outside the ranges", ShapeSplit::kOutside, false},
                         Split{"unseen_families", "Unseen families", ShapeSplit::kSeen, true}}) {
    const Image<Rgb8> sheet = Sheet(page, model.network, s.split, s.held_out);
    if (sheet.empty()) continue;
    html.Heading(s.title);
    const std::string file = std::string("completions_") + s.name + ".png";
    WritePng(folder / file, sheet);
    html.WidePicture(
        file,
        "depth with the segment (occluders are orange), the completion from the camera "
        "and from its side, the truth from the camera and from its side");
  }
  html.Heading("Settings");
  html.Preformatted(page.settings);
  WriteFileAtomically(folder / kCompletionCurvesFile, CurvesCsv(page.report));
  return WritePage(folder / kIndexPage, html);
}

}  // namespace pickbed::eval
