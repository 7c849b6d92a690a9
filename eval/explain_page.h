#pragma once

// Writes the page of an explained image and its pictures; the inside of explain.h.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/explain.h"
#include "eval/report/draw_tiles.h"
#include "eval/report/html_page.h"

namespace pickbed {

class Explainer {
 public:
  // Judges all poses where the truth is known.
  Explainer(const Explained& in, const std::filesystem::path& folder);

  void Write();

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
  void Fates();

  void Stage(const std::string& heading, const std::string& how_to_read);
  // Writes the picture and shows it.
  void Show(const std::string& name, const Image<Rgb8>& picture, const std::string& caption,
            bool wide = true);
  void ShowGallery(const std::string& name, const std::vector<explain::PoseTile>& tiles,
                   const std::string& caption);

  static std::string Percent(double share);
  std::string FitText(int object, const Pose& X_CO, const FitReport& fit) const;
  Eigen::Vector2d Pixel(int index) const {
    const int width = in_.frame.intrinsics.width;
    return {index % width, index / width};
  }
  Eigen::Vector2d MiddlePixel(int object, const Pose& X_CO) const {
    return Project(in_.frame.intrinsics, X_CO * in_.objects[object]->mass.com_O);
  }
  Rgb8 ColorOf(const PoseVerdict& error) const {
    if (error.right()) return explain::kRight;
    return error.diameters < kReachDiameters ? explain::kNear : explain::kWrong;
  }
  // By the truth, where it is known.
  Rgb8 ColorOfPose(int object, const Pose& X_CO) const {
    return judge_ ? ColorOf((*judge_)(object, X_CO)) : explain::kUnknown;
  }
  std::string PartName(int object) const {
    return in_.objects.size() > 1 ? in_.objects[object]->name + "  " : "";
  }
  std::string TruthText(int object, const Pose& X_CO) const;
  std::vector<LegendEntry> TruthLegend(const std::string& right, const std::string& near,
                                       const std::string& wrong) const;
  explain::PoseTile TileOf(int object, const Pose& X_CO, std::string title,
                           std::string caption) const;
  explain::QueryTile QueryOf(int patch, int first_vote, int votes) const;
  // Of `parts`, in this order; the first row is the header.
  std::vector<std::vector<std::string>> FateTable(const std::vector<int>& parts) const;
  // Candidates that are neither accepted nor the same as one that is, best first, each pose once.
  std::vector<int> WhollyRejected() const;
  std::string WhyRejected(const PoseHypothesis& hypothesis) const;

  const Explained& in_;
  std::filesystem::path folder_;
  HtmlPage page_;
  explain::Board board_;
  PartOutlines outlines_;
  std::vector<ModelPoints> models_;
  std::vector<PoseDistance> distances_;
  std::optional<PoseJudge> judge_;
  std::vector<PoseVerdict> vote_errors_;  // of trace.votes
  std::vector<Verdict> verdicts_;         // of hypotheses
  std::vector<PartFate> fates_;           // of the true parts
};

}  // namespace pickbed
