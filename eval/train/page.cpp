#include "eval/train/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "eval/page/vega.h"
#include "eval/summary/result_files.h"
#include "eval/train/draw.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

constexpr int kPairTiles = 36, kAnswerTiles = 24;
constexpr int kEmbeddingWidth_px = 900, kEmbeddingHeight_px = 640;

std::string Share(double share) { return share < 0 ? "-" : fmt::format("{:.3f}", share); }

TableCells FamilyTable(const TrainingReport& report, const ObjectSet& objects) {
  TableCells table{{"object", "recall@1 before", "recall@1", "recall@8",
                    "verifier's area under the curve", "in the start model"}};
  const HeldOutRecall &first = report.recall_history.front(), &last = report.recall_history.back();
  for (size_t i = 0; i < objects.size(); ++i) {
    table.push_back({objects[i]->name, Share(first.object_at_1[i]), Share(last.object_at_1[i]),
                     Share(last.object_at_8[i]), Share(report.object_auc[i]),
                     report.rehearsed[i] ? "yes" : "no"});
  }
  return table;
}

ReportChart LossChart(const TrainingReport& report) {
  constexpr int kPoints = 50;
  ValueCurve curve{"loss", {}};
  for (const Stretch& s : Stretches(report.loss_history, kPoints)) {
    curve.points.push_back({s.x, s.mean, s.minimum, s.maximum});
  }
  return ValueCurves({"loss", "Loss", "Mean of each interval of steps; shaded: its range.", ""},
                     "step", "loss", {curve});
}

ReportChart RecallChart(const TrainingReport& report) {
  ValueCurve first{"recall@1", {}}, eight{"recall@8", {}};
  for (const HeldOutRecall& recall : report.recall_history) {
    const double x = recall.iteration;
    first.points.push_back({x, recall.at_1, recall.at_1, recall.at_1});
    eight.points.push_back({x, recall.at_8, recall.at_8, recall.at_8});
  }
  return ValueCurves({"recall", "Held-out recall",
                      "Share of the held-out queries with a right answer among the nearest one or "
                      "eight neighbours.",
                      ""},
                     "step", "recall", {first, eight}, /*y_max=*/1);
}

std::string CurvesCsv(const TrainingReport& report, const ObjectSet& objects) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  std::string csv = HeaderLine(CurvesColumns(names));
  for (const HeldOutRecall& recall : report.recall_history) {
    const int step = recall.iteration;
    const std::string loss =
        step > 0 ? fmt::format("{:.6f}", report.loss_history[step - 1]) : std::string();
    csv += fmt::format("{},{},{:.6f},{:.6f}", step, loss, recall.at_1, recall.at_8);
    for (const double share : recall.object_at_1) csv += fmt::format(",{:.6f}", share);
    csv += "\n";
  }
  return csv;
}

TableCells TimeTable(const TrainingReport& report) {
  TableCells table{{}};
  for (const ResultColumn& column : TrainingTimingsColumns()) {
    table.front().push_back(column.name);
  }
  for (const auto& phase : report.phases) {
    table.push_back({phase.name, fmt::format("{:.1f}", phase.seconds)});
  }
  table.push_back({"all", fmt::format("{:.1f}", report.seconds)});
  return table;
}

std::string TimingsCsv(const TrainingReport& report) {
  std::string csv;
  for (const auto& row : TimeTable(report)) csv += row[0] + "," + row[1] + "\n";
  return csv;
}

std::string Summary(const TrainingPage& page) {
  const TrainingReport& report = page.report;
  std::string text =
      fmt::format("{} steps on views of sensor {}.", report.loss_history.size(), page.sensor);
  if (report.plateau_iteration >= 0) {
    text += fmt::format(
        " Held-out recall reached a plateau at step {}, where the training schedule was shortened.",
        report.plateau_iteration);
  }
  return text +
         " Held-out queries are patches of clutter scenes that were not used for training. The "
         "code book has a similar patch for each of them, and patches at random poses. An answer "
         "is right if its pose is within 0.1 diameter; symmetric poses count as equal.";
}

}  // namespace

ResultColumns CurvesColumns(const std::vector<std::string>& objects) {
  ResultColumns columns{
      {"step", "number of training steps so far"},
      {"loss", "loss of the last step"},
      {"recall_at_1", "share of held-out queries whose nearest neighbour is right", "0..1"},
      {"recall_at_8", "share with a right answer among eight neighbours", "0..1"},
  };
  for (const std::string& object : objects) {
    columns.push_back({object, "recall_at_1 of this object", "0..1"});
  }
  return columns;
}

ResultColumns TrainingTimingsColumns() {
  return {{"what", "phase of the training, or all"}, {"seconds", "duration"}};
}

std::vector<Stretch> Stretches(const std::vector<double>& values, int maximum) {
  std::vector<Stretch> stretches;
  const size_t count = std::min<size_t>(maximum, values.size());
  for (size_t i = 0; i < count; ++i) {
    const auto begin = values.begin() + i * values.size() / count;
    const auto end = values.begin() + (i + 1) * values.size() / count;
    const double size = static_cast<double>(end - begin);
    const auto [minimum, maximum] = std::minmax_element(begin, end);
    stretches.push_back({static_cast<double>(begin - values.begin()) + 0.5 * size,
                         std::accumulate(begin, end, 0.0) / size, *minimum, *maximum});
  }
  return stretches;
}

std::string WriteTrainingPage(const std::filesystem::path& folder, const TrainingPage& page) {
  MakeFolder(folder);
  const TrainingReport& report = page.report;
  HtmlPage html("Training of " + page.name);
  html.Paragraph(Summary(page));
  html.Table(FamilyTable(report, page.objects));
  html.Heading("Curves");
  html.Charts({LossChart(report), RecallChart(report)});

  const auto picture = [&](const std::string& file, const Image<Rgb8>& image,
                           const std::string& caption) {
    if (image.empty()) return;
    WritePng(folder / file, image);
    html.WidePicture(file, caption);
  };
  html.Heading("Descriptors of held-out queries");
  picture("embedding.png",
          DrawEmbedding(report.answers, page.objects, kEmbeddingWidth_px, kEmbeddingHeight_px),
          page.objects.size() == 1 ? "first two principal axes; color: viewing direction in the "
                                     "object frame (x, y, z as red, green, blue)"
                                   : "first two principal axes; color: object");
  html.Heading("Nearest neighbours");
  picture("answers.png",
          DrawAnswers(report.answers, report.held_out, report.channels, page.objects, kAnswerTiles),
          "query, nearest code book entry, true entry: wrong answers first");
  html.Heading("Training pairs");
  const int per_object = std::max(1, kPairTiles / static_cast<int>(page.objects.size()));
  picture(
      "pairs.png", DrawPairs(report.pairs, report.channels, page.objects, per_object),
      std::string("a patch of a clutter scene and the same patch of the object without clutter: it "
                  "differs by sensor noise, clutter, holes, and a small rotation and shift. ") +
          (report.channels == PatchChannels::kDepthColor
               ? "Colors of the image; the network also gets depth"
               : "Colors show normals, darker is farther"));
  html.Heading("Seconds");
  html.Table(TimeTable(report));
  html.Heading("Settings");
  html.Preformatted(page.settings);
  WriteFileAtomically(folder / kCurvesFile, CurvesCsv(report, page.objects));
  WriteFileAtomically(folder / kTimingsFile, TimingsCsv(report));
  return WritePage(folder / kIndexPage, html);
}

}  // namespace pickbed::eval
