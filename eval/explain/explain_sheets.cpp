#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "eval/explain/codebook_patches.h"
#include "eval/explain/explain_page.h"

namespace pickbed::eval {

namespace {

constexpr int kQueries = 12, kQueryNeighbors = 5;
constexpr size_t kGalleryTiles = 15, kBestTiles = 10;

// The colors follow Okabe and Ito ("Color Universal Design", 2008). Each instance also has a number
// that leads to the table.
Rgb8 OutcomeColor(FailingStage stage) {
  switch (stage) {
    case FailingStage::kFound:
      return kRightColor;
    case FailingStage::kHardlyVisible:
      return kPaleColor;
    case FailingStage::kPoints:
      return {120, 80, 50};
    case FailingStage::kVotes:
      return {213, 94, 0};
    case FailingStage::kSelection:
      return {230, 159, 0};
    case FailingStage::kIcp:
      return {240, 228, 66};
    case FailingStage::kMerging:
      return {250, 245, 205};
    case FailingStage::kVerifier:
      return {204, 121, 167};
    case FailingStage::kPoseSelection:
      return {0, 158, 115};
    case FailingStage::kCount:
      return {0, 70, 130};
    case FailingStage::kRefiner:
      return {150, 225, 235};
  }
  return kPaleColor;
}

}  // namespace

std::string Explainer::FitText(ObjectId object, const Pose& X_CO, const FitReport& fit) const {
  std::string text =
      fmt::format("agree {}, hidden {}, violate {}", WholePercentText(fit.inlier_share),
                  WholePercentText(fit.hidden_share), WholePercentText(fit.violated_share));
  const auto correlation = TextureCorrelation(in_.trace.cloud, models_[object], X_CO);
  if (correlation) text += fmt::format(", texture {:.2f}", *correlation);
  return text;
}

QueryTile Explainer::QueryOf(int index, int first_vote, int votes) const {
  const TracedPatch& patch = in_.trace.patches[index];
  QueryTile query;
  query.patch = &patch;
  query.pixel = Pixel(patch.pixel);
  const double px_per_m = in_.frame.intrinsics.fx() / patch.X_CP.translation().z();
  query.side_px = patch.side_m * px_per_m;
  double diameter_m = 0;
  for (int i = 0; i < std::min(votes, kQueryNeighbors); ++i) {
    const RawHypothesis& vote = in_.trace.votes[first_vote + i].vote;
    diameter_m = std::max(diameter_m, in_.objects[vote.object]->diameter_m);
    query.neighbors.push_back(
        {std::nullopt, vote.object, vote.X_CO, ColorOfPose(vote.object, vote.X_CO),
         fmt::format("{:.2f}  {}{}", in_.trace.votes[first_vote + i].distance,
                     ObjectName(vote.object), TruthText(vote.object, vote.X_CO))});
  }
  query.view_px = std::max(1.5 * query.side_px, 1.5 * diameter_m * px_per_m);
  return query;
}

void Explainer::Patches() {
  const EstimateTrace& trace = in_.trace;
  if (trace.votes.empty()) return;
  Stage("3. Patches and their nearest code book entries",
        "Right neighbours are similar to the query because they show the same place of the object. "
        "Wrong neighbours that are equally similar must be outvoted.");
  std::map<int, std::pair<int, int>> votes_of;  // patch -> index of first vote, number of votes
  for (size_t i = 0; i < trace.votes.size(); ++i) {
    ++votes_of.try_emplace(trace.votes[i].patch, static_cast<int>(i), 0).first->second.second;
  }
  std::vector<QueryTile> queries;
  std::vector<EntryPose> entries;
  const int count = static_cast<int>(trace.patches.size());
  for (int q = 0; q < std::min(kQueries, count); ++q) {
    const int patch = (2 * q + 1) * count / (2 * std::min(kQueries, count));
    const auto votes = votes_of.find(patch);
    if (votes == votes_of.end()) continue;
    queries.push_back(QueryOf(patch, votes->second.first, votes->second.second));
    for (const NeighborTile& neighbor : queries.back().neighbors) {
      entries.push_back({neighbor.object,
                         {trace.patches[patch].side_m, trace.channels},
                         trace.patches[patch].X_CP.inverse() * neighbor.X_CO});
    }
  }
  const auto patches =
      EntryPatches(in_.views, entries, in_.working_distance_m, in_.frame.intrinsics.fx());
  size_t next = 0;
  for (QueryTile& query : queries) {
    for (NeighborTile& neighbor : query.neighbors) neighbor.patch = patches[next++];
  }
  Show("3_patches",
       PatchSheet(board_, outlines_, queries, trace.channels,
                  TruthLegend("votes for the right pose", "within 0.25 d: in ICP's reach",
                              "votes for a wrong pose")),
       std::string("Each block: the query patch ") +
           (trace.channels == PatchChannels::kDepthColor
                ? "(its colors; the network sees its depth, too)"
                : "(depth, near is warm, shaded by its normals)") +
           " and the nearest entries, rendered anew; below, the place of the patch and the pose "
           "that each entry votes for. Numbers are descriptor distances.");
}

PoseTile Explainer::TileOf(ObjectId object, const Pose& X_CO, std::string title,
                           std::string caption) const {
  return {object,
          X_CO,
          ColorOfPose(object, X_CO),
          JudgePoints(in_.trace.cloud, models_[object], X_CO),
          std::move(title),
          std::move(caption)};
}

void Explainer::Accepted() {
  Stage(
      "6. Input of the verifier",
      fmt::format("Each dot is a model point that faces the camera. A right pose is blue except "
                  "where it is hidden (black). Orange is evidence against it: the camera measured "
                  "a surface behind the model point. Texture: how well the colors of a printed "
                  "object match, up to 1; below {:g} it lowers the score.",
                  kTextureFound));
  std::vector<PoseTile> tiles;
  const std::vector<Verdict> verdicts =
      judge_ ? JudgeSet(*judge_, in_.trace.accepted) : std::vector<Verdict>();
  for (size_t i = 0; i < in_.trace.accepted.size() && tiles.size() < kGalleryTiles; ++i) {
    const PoseHypothesis& h = in_.trace.accepted[i];
    // Shows the best poses. Further ones are shown only if they are not right.
    if (i >= kBestTiles && (!judge_ || verdicts[i] == Verdict::kRight)) continue;
    tiles.push_back(TileOf(
        h.object, h.X_CO,
        fmt::format("{}{:.2f}  {}", ObjectName(h.object), h.score, TruthText(h.object, h.X_CO)),
        FitText(h.object, h.X_CO, h.fit)));
  }
  if (tiles.empty()) {
    page_.Paragraph("No pose was accepted.");
    return;
  }
  ShowGallery("6_accepted", tiles,
              "Accepted poses with the score of the verifier: the best one, and the wrong ones; "
              "before the final refiner");
}

std::vector<int> Explainer::WhollyRejected() const {
  std::vector<int> order(in_.trace.candidates.size());
  std::iota(order.begin(), order.end(), 0);
  const auto& candidates = in_.trace.candidates;
  std::ranges::stable_sort(order, [&](int a, int b) {
    return candidates[a].hypothesis.score > candidates[b].hypothesis.score;
  });
  std::vector<int> rejected;
  for (const int i : order) {
    const PoseHypothesis& h = candidates[i].hypothesis;
    const auto same = [&](const PoseHypothesis& other) {
      return other.object == h.object &&
             distances_[h.object](other.X_CO, h.X_CO) < kCorrectDiameters;
    };
    if (std::ranges::any_of(in_.trace.accepted, same)) continue;
    if (std::ranges::any_of(rejected, [&](int r) { return same(candidates[r].hypothesis); })) {
      continue;
    }
    rejected.push_back(i);
    if (rejected.size() == kBestTiles) break;
  }
  return rejected;
}

std::string Explainer::WhyRejected(const PoseHypothesis& hypothesis) const {
  if (hypothesis.score < in_.trace.min_score) {
    return fmt::format("under {:g}", in_.trace.min_score);
  }
  return CountUsedUp(in_.trace, hypothesis.object, hypothesis.score) ? "over the instance count"
                                                                     : "suppressed";
}

void Explainer::Rejected() {
  std::vector<PoseTile> tiles;
  for (const int i : WhollyRejected()) {
    const PoseHypothesis& h = in_.trace.candidates[i].hypothesis;
    tiles.push_back(TileOf(h.object, h.X_CO,
                           fmt::format("{}{:.2f} {}  {}", ObjectName(h.object), h.score,
                                       WhyRejected(h), TruthText(h.object, h.X_CO)),
                           FitText(h.object, h.X_CO, h.fit)));
  }
  if (tiles.empty()) return;
  ShowGallery("6_rejected", tiles,
              "The best rejected poses: their score is under the threshold, a better pose explains "
              "the same pixels, or the given number of instances of this object was reached with "
              "higher scores");
}

void Explainer::Missed() {
  std::vector<int> missed;
  for (size_t i = 0; i < outcomes_.size(); ++i) {
    if (outcomes_[i].failing_stage == FailingStage::kFound ||
        outcomes_[i].failing_stage == FailingStage::kHardlyVisible)
      continue;
    missed.push_back(static_cast<int>(i));
  }
  std::ranges::stable_sort(missed, [&](int a, int b) {
    return judge_->instances()[a].visible_fraction > judge_->instances()[b].visible_fraction;
  });
  if (missed.size() > kGalleryTiles) missed.resize(kGalleryTiles);
  std::vector<PoseTile> tiles;
  for (const int i : missed) {
    const TrueInstance& instance = judge_->instances()[i];
    PoseTile tile =
        TileOf(instance.object, instance.X_CO,
               fmt::format("{}{} visible, failing stage: {}", ObjectName(instance.object),
                           WholePercentText(instance.visible_fraction),
                           TextOf(outcomes_[i].failing_stage).name),
               "");
    const FitReport fit = MeasureFit(in_.trace.cloud, models_[instance.object], instance.X_CO);
    tile.caption = FitText(instance.object, instance.X_CO, fit);
    tile.color = kUnknownColor;
    tiles.push_back(std::move(tile));
  }
  if (tiles.empty()) return;
  ShowGallery("6_missed", tiles,
              "Missed instances at their true poses, as the verifier would have scored them");
}

void Explainer::Final() {
  Stage("7. Result",
        "Poses after the final refiner with their scores: the verifier's estimate of the "
        "probability that they are right.");
  std::vector<DrawnPose> poses;
  for (size_t i = 0; i < in_.hypotheses.size(); ++i) {
    const PoseHypothesis& h = in_.hypotheses[i];
    DrawnPose pose{h.object, h.X_CO, kUnjudgedColor, fmt::format("{:.2f}", h.score)};
    if (judge_) {
      pose.mark = verdicts_[i] == Verdict::kRight ? PoseMark::kRight : PoseMark::kWrong;
      pose.color = pose.mark == PoseMark::kRight ? kRightColor : kWrongColor;
      if (pose.mark == PoseMark::kWrong) pose.style = LineStyle::kDashed;
    }
    poses.push_back(std::move(pose));
  }
  std::vector<KeyEntry> key;
  if (judge_) {
    key = {{"right", KeyEntry::Sample::kMark, PoseMark::kRight, {kRightColor}},
           {"wrong, or the second pose of an instance",
            KeyEntry::Sample::kMark,
            PoseMark::kWrong,
            {kWrongColor, LineStyle::kDashed}}};
  }
  key.push_back({"number: score"});
  Show("7_final", DrawPoses(board_, in_.objects, poses, key),
       fmt::format("{} poses with a score of {:g} or more", poses.size(), in_.trace.min_score));
}

// Writes the number of instances by failing stage, then a table of all instances.
void Explainer::Outcomes() {
  if (outcomes_.empty()) return;
  Stage("8. Failing stage of each instance",
        "The first stage after which no candidate was left that would have found the instance. "
        "Improve this stage first.");
  std::vector<int> order(outcomes_.size());
  std::iota(order.begin(), order.end(), 0);
  const std::vector<TrueInstance>& instances = judge_->instances();
  std::ranges::stable_sort(order, [&](int a, int b) {
    return instances[a].visible_fraction > instances[b].visible_fraction;
  });
  std::map<FailingStage, int> counts_by_stage;
  std::vector<DrawnPose> poses;
  for (const int i : order) {
    ++counts_by_stage[outcomes_[i].failing_stage];
    const TrueInstance& instance = instances[i];
    poses.push_back({instance.object, instance.X_CO, OutcomeColor(outcomes_[i].failing_stage),
                     std::to_string(i + 1)});
  }
  std::vector<LegendEntry> legend;
  std::vector<std::vector<std::string>> counts{{"failing stage", "instances", "meaning"}};
  for (const auto& [stage, count] : counts_by_stage) {
    const FailingStageText text = TextOf(stage);
    legend.push_back({OutcomeColor(stage), text.name});
    counts.push_back({text.name, std::to_string(count), text.help});
  }
  page_.Table(counts);
  Show("8_parts", DrawPoses(board_, in_.objects, poses, LineKey(legend)),
       "The true poses, numbered as below");
  page_.Table(OutcomeTable(order));
}

std::vector<std::vector<std::string>> Explainer::OutcomeTable(
    const std::vector<int>& instances) const {
  std::vector<std::vector<std::string>> rows{{"instance", "object", "visible", "patches",
                                              "votes within reach", "votes right", "best start, d",
                                              "after ICP, d", "best right score", "failing stage"}};
  const auto number = [](double value) {
    return value < 9.995 ? fmt::format("{:.2f}", value) : std::string("-");
  };
  for (const int i : instances) {
    const InstanceDiagnosis& instance_outcome = outcomes_[i];
    const TrueInstance& instance = judge_->instances()[i];
    rows.push_back(
        {std::to_string(i + 1), in_.objects[instance.object]->name,
         WholePercentText(instance.visible_fraction), std::to_string(instance_outcome.points),
         std::to_string(instance_outcome.votes_near), std::to_string(instance_outcome.votes_right),
         number(instance_outcome.best_start), number(instance_outcome.best_refined),
         instance_outcome.best_score < 0 ? "-" : fmt::format("{:.2f}", instance_outcome.best_score),
         TextOf(instance_outcome.failing_stage).name});
  }
  return rows;
}

}  // namespace pickbed::eval
