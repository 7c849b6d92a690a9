#include "eval/explain/explain_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "eval/cell/simulated_cell.h"
#include "eval/draw/bin_view.h"
#include "eval/draw/overlay.h"
#include "eval/stats/statistics.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {

namespace {

constexpr int kFollowed = 30;  // number of poses shown before and after ICP

}  // namespace

Explainer::Explainer(const Explained& in, const std::filesystem::path& folder)
    : in_(in),
      folder_(folder),
      page_(in.title),
      board_(in.frame, in.region ? *in.region : ForegroundRegion(in.trace.cloud)),
      outlines_(in.objects) {
  for (const auto& object : in.objects) {
    models_.push_back(MakeModelPoints(*object));
    distances_.emplace_back(*object);
  }
  if (!in.truth) return;
  judge_.emplace(in.objects, *in.truth);
  for (const TracedVote& vote : in.trace.votes) {
    vote_errors_.push_back((*judge_)(vote.vote.object, vote.vote.X_CO));
  }
  verdicts_ = JudgeSet(*judge_, in.hypotheses);
  outcomes_ = DiagnoseInstances(*judge_, in.trace, vote_errors_, models_, in.hypotheses);
}

ExplanationPage Explainer::Write() {
  MakeFolder(folder_ / "pictures" / in_.image);
  Summary();
  Input();
  Points();
  Patches();
  Votes();
  Hypotheses();
  Accepted();
  Rejected();
  Missed();
  Final();
  Outcomes();
  ExplanationPage written;
  written.file = folder_ / ExplainPageName(in_.image);
  written.replaced = std::filesystem::exists(written.file);
  written.unwritten = WritePage(written.file, page_);
  return written;
}

void Explainer::Stage(const std::string& heading, const std::string& how_to_read) {
  page_.Heading(heading);
  page_.Paragraph(how_to_read);
}

void Explainer::Show(const std::string& name, const Image<Rgb8>& picture,
                     const std::string& caption, bool wide) {
  const std::string path = fmt::format("pictures/{}/{}.png", in_.image, name);
  WritePng(folder_ / path, picture);
  if (wide) {
    page_.WidePicture(path, caption);
  } else {
    page_.Picture(path, caption);
  }
}

void Explainer::ShowGallery(const std::string& name, const std::vector<PoseTile>& tiles,
                            const std::string& caption) {
  Show(name, PoseGallery(board_, outlines_, in_.objects, models_, tiles), caption);
}

std::vector<LegendEntry> Explainer::TruthLegend(const std::string& right, const std::string& near,
                                                const std::string& wrong) const {
  if (!judge_) return {{kUnknownColor, "ground truth is not known here"}};
  return {{kRightColor, right}, {kNearColor, near}, {kWrongColor, wrong}};
}

std::string Explainer::TruthText(ObjectId object, const Pose& X_CO) const {
  if (!judge_) return "";
  const InstanceMatch error = (*judge_)(object, X_CO);
  if (error.position < 0) return "no such instance";
  if (error.correct) return "right";
  return error.mssd_diameters < 9.95 ? fmt::format("error {:.2f} d", error.mssd_diameters)
                                     : "large error";
}

void Explainer::Summary() {
  std::string text = fmt::format(
      "{} patches cast {} votes; {} poses were refined, {} scored by the verifier and {} reported.",
      in_.trace.patches.size(), in_.trace.votes.size(), in_.trace.refinements.size(),
      in_.trace.candidates.size(), in_.hypotheses.size());
  const std::vector<int>& counts = in_.trace.instances;
  if (!counts.empty()) {
    text += fmt::format(" The number of instances of each object was given, {} in all.",
                        std::accumulate(counts.begin(), counts.end(), 0));
  }
  if (judge_) {
    const auto right = std::ranges::count(verdicts_, Verdict::kRight);
    size_t wanted = 0, found = 0;
    for (size_t i = 0; i < outcomes_.size(); ++i) {
      if (judge_->instances()[i].visible_fraction < kCountedVisibility) continue;
      ++wanted;
      found += outcomes_[i].failing_stage == FailingStage::kFound;
    }
    text += fmt::format(
        " According to ground truth, {} of the {} reported poses are right, and {} of the {} "
        "instances at least {} visible were found. A pose is right if its error (MSSD) is under "
        "{:g} diameters; d below is diameters.",
        right, in_.hypotheses.size(), found, wanted, WholePercentText(kCountedVisibility),
        kCorrectDiameters);
  } else {
    text += " Ground truth is not known here, so no pose is marked as right or wrong.";
  }
  page_.Paragraph(text);
}

void Explainer::Input() {
  Stage("1. Camera image",
        "Only foreground pixels can be sampled; an instance without depth cannot be found.");
  std::vector<float> known;
  for (const float z : in_.frame.depth_m.pixels()) {
    if (z > 0) known.push_back(z);
  }
  std::ranges::sort(known);
  const double holes =
      1 - static_cast<double>(known.size()) / std::max<size_t>(1, in_.frame.depth_m.size());
  const auto at = [&](double share) {
    return known.empty() ? 0.f : known[static_cast<size_t>(share * (known.size() - 1))];
  };
  if (!in_.frame.color.empty()) {
    Show("1_color", Cropped(in_.frame.color, board_.region), "Color", false);
  }
  Show("1_depth", Cropped(ColorizeDepth(in_.frame.depth_m), board_.region),
       fmt::format("Depth: near is warm, {:.3f} to {:.3f} m; black has no reading ({})", at(0.01),
                   at(0.99), PercentText(holes)),
       false);
  Show("1_foreground", Cropped(DrawForeground(in_.frame, in_.trace.cloud), board_.region),
       "Foreground in its colors; background is dimmed, violet has no reading", false);
}

void Explainer::Points() {
  const size_t count = in_.trace.patches.size();
  Stage("2. Sampled points",
        "A patch is cut around each point and votes for object poses. Where many points have no "
        "right vote, the descriptors do not recognise the surface: it is too hidden, too plain, or "
        "was not trained.");
  std::map<int, int> right_by_pixel;
  for (const TracedPatch& patch : in_.trace.patches) right_by_pixel[patch.pixel] += 0;
  for (size_t i = 0; i < vote_errors_.size(); ++i) {
    const int pixel = in_.trace.patches[in_.trace.votes[i].patch].pixel;
    right_by_pixel[pixel] += vote_errors_[i].correct;
  }
  std::vector<ColoredDot> dots;
  int none = 0;
  for (const auto& [pixel, right] : right_by_pixel) {
    const Rgb8 by_truth = right == 0 ? kWrongColor : right == 1 ? kNearColor : kRightColor;
    dots.push_back({Pixel(pixel), judge_ ? by_truth : kUnknownColor});
    none += right == 0;
  }
  std::string caption = fmt::format("{} points, {} patches", dots.size(), count);
  if (judge_) {
    caption +=
        fmt::format("; {} of the points have no right vote",
                    WholePercentText(static_cast<double>(none) / std::max<size_t>(1, dots.size())));
  }
  Show("2_points",
       DrawDots(board_, dots, 2.6,
                TruthLegend("two or more of its votes are right", "one vote is right",
                            "no vote is right")),
       caption);
}

void Explainer::Votes() {
  Stage("4. Votes",
        "Each vote gives a position of an object center. Bright spots on rings are instances that "
        "many patches agree on; bright spots elsewhere are ambiguous poses, and dark rings got no "
        "votes.");
  std::vector<Eigen::Vector2d> centers;
  std::vector<ColoredDot> dots[3];  // wrong, near, right: right ones are drawn on top
  for (size_t i = 0; i < in_.trace.votes.size(); ++i) {
    const RawHypothesis& vote = in_.trace.votes[i].vote;
    if (!((vote.X_CO * in_.objects[vote.object]->mass.com_O).z() > 0)) continue;
    centers.push_back(CenterPixel(vote.object, vote.X_CO));
    if (!judge_) continue;
    const Rgb8 color = ColorOf(vote_errors_[i]);
    dots[color == kRightColor ? 2 : color == kNearColor ? 1 : 0].push_back({centers.back(), color});
  }
  double diameter_m = 0;
  for (const auto& object : in_.objects) diameter_m += object->diameter_m / in_.objects.size();
  const double sigma_px =
      std::max(1.0, 0.03 * diameter_m * in_.frame.intrinsics.fx() / in_.working_distance_m);
  std::vector<ColoredDot> rings;
  for (size_t i = 0; i < outcomes_.size(); ++i) {
    const TrueInstance& instance = judge_->instances()[i];
    const bool found = outcomes_[i].failing_stage == FailingStage::kFound;
    const Rgb8 not_found =
        outcomes_[i].failing_stage == FailingStage::kHardlyVisible ? kPaleColor : kUnknownColor;
    rings.push_back({CenterPixel(instance.object, instance.X_CO), found ? kRightColor : not_found});
  }
  std::vector<LegendEntry> legend;
  if (judge_) {
    legend = {{kRightColor, "an instance that was found"},
              {kUnknownColor, "an instance that was not found"},
              {kPaleColor, "an instance that is barely visible"}};
  }
  Show("4_votes", DrawVoteMap(board_, centers, sigma_px, rings, legend),
       fmt::format("{} votes, {} of each patch: density of the voted object centers",
                   in_.trace.votes.size(), in_.trace.neighbors));
  if (!judge_) return;
  std::vector<ColoredDot> all;
  for (const auto& of_color : dots) all.insert(all.end(), of_color.begin(), of_color.end());
  const auto share = [&](const std::vector<ColoredDot>& some) {
    return WholePercentText(static_cast<double>(some.size()) / std::max<size_t>(1, all.size()));
  };
  Show("4_votes_by_truth",
       DrawDots(board_, all, 1.6,
                TruthLegend("right: " + share(dots[2]), "within ICP's reach: " + share(dots[1]),
                            "wrong: " + share(dots[0]))),
       "The same object centers one by one. Right means that the whole pose is right, so a wrong "
       "vote can be on the center of an instance");
}

void Explainer::Hypotheses() {
  Stage("5. Hypotheses before and after ICP",
        "The votes with the best ranks, and their poses after ICP. Yellow before should be blue "
        "after; orange before stays wrong, and yellow that turned orange converged to clutter.");
  std::vector<const TracedRefinement*> followed;
  for (const TracedRefinement& refinement : in_.trace.refinements) {
    if (!refinement.ambiguous_pose) followed.push_back(&refinement);
  }
  std::ranges::stable_sort(followed, [](const TracedRefinement* a, const TracedRefinement* b) {
    return a->before.quick_score > b->before.quick_score;
  });
  if (followed.size() > kFollowed) followed.resize(kFollowed);
  const auto legend = TruthLegend("right", "within 0.25 d: in ICP's reach", "wrong");
  const auto draw = [&](const char* name, const std::string& when,
                        RawHypothesis TracedRefinement::*which) {
    std::vector<DrawnPose> poses;
    int right = 0;
    for (const TracedRefinement* refinement : followed) {
      const RawHypothesis& pose = refinement->*which;
      poses.push_back(DrawnOf(pose.object, pose.X_CO));
      right += poses.back().color == kRightColor;
    }
    const std::string how_many = judge_ ? fmt::format(": {} right", right) : "";
    Show(name, DrawPoses(board_, in_.objects, poses, LineKey(legend)),
         fmt::format("The best {} {} ICP{}", followed.size(), when, how_many));
  };
  draw("5_before_icp", "before", &TracedRefinement::before);
  draw("5_after_icp", "after", &TracedRefinement::after);
}

std::string ExplainPageName(const std::string& image) {
  return fmt::format("explain_{}.html", image);
}

std::string TrialImageName(int trial) { return fmt::format("trial_{}", trial); }

std::string DatasetImageName(int scene, int image) {
  return fmt::format("image_{}_{}", scene, image);
}

ExplanationPage WriteExplanation(const Explained& explained, const std::filesystem::path& folder) {
  const OrganizedCloud& cloud = explained.trace.cloud;
  const int width = explained.frame.intrinsics.width();
  if (cloud.intrinsics.width() == width) return Explainer(explained, folder).Write();
  // The estimator searched a reduced image, to which all pixels of the trace refer.
  const RgbdFrame searched{cloud.intrinsics, cloud.color, cloud.depth_m};
  std::optional<ImageBox> region = explained.region;
  if (region) {
    const int factor = width / cloud.intrinsics.width();
    region = ImageBox{region->x / factor, region->y / factor, region->width / factor,
                      region->height / factor};
  }
  const Explained reduced{explained.title,
                          explained.image,
                          searched,
                          explained.objects,
                          explained.trace,
                          explained.hypotheses,
                          explained.truth,
                          explained.views,
                          explained.working_distance_m,
                          region};
  return Explainer(reduced, folder).Write();
}

}  // namespace pickbed::eval
