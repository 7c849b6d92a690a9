#pragma once

// Class behind WriteExplanation() in explain.h: writes the page of an explained image and its
// pictures.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/explain/draw_tiles.h"
#include "eval/explain/explain.h"
#include "eval/page/html.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// Writes the page section by section. Each private function without arguments writes one section.
class Explainer {
 public:
  // Compares all poses with the ground truth, if it is known.
  Explainer(const Explained& in, const std::filesystem::path& folder);

  // Writes all pictures and then the page.
  ExplanationPage Write();

 private:
  void Summary();
  void Input();
  void Points();
  void Patches();
  void Votes();
  void Hypotheses();
  void Accepted();
  void Rejected();
  void Missed();
  void Final();
  void Outcomes();

  void Stage(const std::string& heading, const std::string& how_to_read);
  // Writes the picture to a file and adds it to the page.
  void Show(const std::string& name, const Image<Rgb8>& picture, const std::string& caption,
            bool wide = true);
  void ShowGallery(const std::string& name, const std::vector<PoseTile>& tiles,
                   const std::string& caption);

  std::string FitText(ObjectId object, const Pose& X_CO, const FitReport& fit) const;
  Eigen::Vector2d Pixel(int index) const {
    const int width = in_.frame.intrinsics.width();
    return {index % width, index / width};
  }
  Eigen::Vector2d CenterPixel(ObjectId object, const Pose& X_CO) const {
    return Project(in_.frame.intrinsics, X_CO * in_.objects[object]->mass.com_O);
  }
  Rgb8 ColorOf(const InstanceMatch& error) const {
    if (error.correct) return kRightColor;
    return error.mssd_diameters < kReachDiameters ? kNearColor : kWrongColor;
  }
  // Color by the error against ground truth; kUnknown without ground truth.
  Rgb8 ColorOfPose(ObjectId object, const Pose& X_CO) const {
    return judge_ ? ColorOf((*judge_)(object, X_CO)) : kUnknownColor;
  }
  // Outline of a pose in its color by truth; a wrong one is dashed.
  DrawnPose DrawnOf(ObjectId object, const Pose& X_CO) const {
    DrawnPose pose{object, X_CO, ColorOfPose(object, X_CO)};
    if (pose.color == kWrongColor) pose.style = LineStyle::kDashed;
    return pose;
  }
  std::string ObjectName(ObjectId object) const {
    return in_.objects.size() > 1 ? in_.objects[object]->name + "  " : "";
  }
  std::string TruthText(ObjectId object, const Pose& X_CO) const;
  std::vector<LegendEntry> TruthLegend(const std::string& right, const std::string& near,
                                       const std::string& wrong) const;
  PoseTile TileOf(ObjectId object, const Pose& X_CO, std::string title, std::string caption) const;
  QueryTile QueryOf(int patch, int first_vote, int votes) const;
  // Header, then one row for each of `instances`, in this order.
  std::vector<std::vector<std::string>> OutcomeTable(const std::vector<int>& instances) const;
  // Rejected candidates, best first, at most ten. A candidate is left out if its pose equals an
  // accepted pose or an earlier candidate (distance under 0.1 diameter).
  std::vector<int> WhollyRejected() const;
  std::string WhyRejected(const PoseHypothesis& hypothesis) const;

  const Explained& in_;
  std::filesystem::path folder_;
  HtmlPage page_;
  Board board_;
  ObjectOutlines outlines_;
  std::vector<ModelPoints> models_;
  std::vector<PoseDistance> distances_;
  std::optional<PoseJudge> judge_;
  std::vector<InstanceMatch> vote_errors_;   // one per entry of trace.votes
  std::vector<Verdict> verdicts_;            // one per hypothesis
  std::vector<InstanceDiagnosis> outcomes_;  // one per ground-truth instance
};

}  // namespace pickbed::eval
