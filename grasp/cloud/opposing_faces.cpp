#include "grasp/cloud/opposing_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace pickbed::grasp {
namespace {

constexpr double kRounding_m = 1e-6;

// Blocked columns [first, last] of a slice.
struct BlockedRun {
  int first = 0, last = 0;
};

// Contact of one pad: silhouette of the measured surface, by row.
struct Side {
  std::vector<int> rows;    // with a contact nearly as far out as the outermost one
  double center_row = 0;    // mean of `rows`
  double cover = 0;         // share of the rows of the pad with surface near the contact
  double slope = 0;         // of the silhouette along the rows; 0 = parallel to the pad
  double engagement_m = 0;  // height of the surface behind the contact above the tips
  double lean = 0;          // silhouette's retreat per height; 0 = parallel to the approach
};

class SliceSearch {
 public:
  SliceSearch(const HeightMap& map, const std::vector<SurfaceSegment>& segments,
              const sim::HandSpec& hand, double clearance_m, double friction,
              const OpposingFacesOptions& options, FaceRejections& rejected)
      : map_(map),
        segments_(segments),
        hand_(hand),
        clearance_m_(clearance_m),
        friction_(friction),
        options_(options),
        rejected_(rejected) {}

  std::vector<FacePair> FindPairs() {
    if (map_.columns == 0) return {};
    MeasureHeights();
    if (!(highest_m_ > lowest_m_)) return {};
    const int pad = Cells(0.5 * hand_.finger_size_m.y() + clearance_m_);
    pad_top_ = RunningMaxOfColumns(map_.solid_m, map_.columns, map_.rows, pad);
    finger_top_ = RunningMaxOfRows(pad_top_, map_.columns, map_.rows,
                                   static_cast<int>(0.5 * hand_.finger_size_m.x() / map_.cell_m));
    const int room = Cells(options_.good_room_m);
    roomy_top_ = RunningMaxOfColumns(finger_top_, map_.columns, map_.rows, room);
    palm_top_ = RunningMaxOfRows(
        RunningMaxOfColumns(map_.solid_m, map_.columns, map_.rows,
                            Cells(0.5 * hand_.palm_size_m.y() + clearance_m_)),
        map_.columns, map_.rows, Cells(0.5 * hand_.palm_size_m.x() + clearance_m_));
    const int row_step = std::max(1, Cells(options_.row_step_m));
    for (double tips_m = lowest_m_ + options_.floor_gap_m;
         tips_m < highest_m_ - options_.min_engagement_m; tips_m += options_.level_step_m) {
      for (int row = 0; row < map_.rows; row += row_step) SearchSlice(row, tips_m);
    }
    return std::move(pairs_);
  }

 private:
  int Cells(double length_m) const {
    return static_cast<int>(std::ceil(length_m / map_.cell_m - 1e-9));
  }

  void MeasureHeights() {
    for (const float solid_m : map_.solid_m) {
      if (std::isfinite(solid_m)) lowest_m_ = std::min<double>(lowest_m_, solid_m);
    }
    for (const float seen_m : map_.seen_m) {
      if (std::isfinite(seen_m)) highest_m_ = std::max<double>(highest_m_, seen_m);
    }
    for (const SurfaceSegment& segment : segments_) {
      const Eigen::Vector3d center_G = map_.R_BG.transpose() * segment.center_B;
      centers_G_.push_back(center_G);
      const double top_m = segment.top_m;
      top_B_m_ = std::max(top_B_m_, top_m);
      bottom_B_m_ = std::min(bottom_B_m_, top_m);
    }
  }

  // Searches one row with the tips at one height.
  void SearchSlice(int row, double tips_m) {
    const float limit_m = static_cast<float>(tips_m - options_.below_tips_m);
    const float* blocked_m = pad_top_.data() + map_.Index(0, row);
    const int max_width =
        static_cast<int>((hand_.stroke_m - 2 * options_.tight_clearance_m) / map_.cell_m);
    runs_.clear();
    for (int column = 0; column < map_.columns; ++column) {
      if (blocked_m[column] <= limit_m) continue;
      if (!runs_.empty() && runs_.back().last == column - 1) {
        runs_.back().last = column;
      } else {
        runs_.push_back({column, column});
      }
    }
    constexpr size_t kMaxRuns = 3;  // of one object, such as the legs of a clip
    for (size_t i = 0; i < runs_.size(); ++i) {
      for (size_t k = i; k < std::min(runs_.size(), i + kMaxRuns); ++k) {
        const int first = runs_[i].first, last = runs_[k].last;
        if (last - first + 1 > max_width) break;
        Rate(row, tips_m, first, last);
      }
    }
  }

  // Rates the pads around the blocked columns [first, last] of a slice.
  void Rate(int row, double tips_m, int first, int last) {
    const int pad_rows = static_cast<int>(0.5 * hand_.finger_size_m.y() / map_.cell_m);
    Side left, right;
    const int main = MainSegment(row, pad_rows, tips_m, first, last);
    if (main == kBackground) return;
    Silhouette(row, pad_rows, tips_m, first, last, outer_left_, outer_right_);
    int left_column = last + 1, right_column = first - 1;
    for (size_t i = 0; i < outer_left_.size(); ++i) {
      if (outer_left_[i] > outer_right_[i]) continue;  // nothing in this row
      left_column = std::min(left_column, outer_left_[i]);
      right_column = std::max(right_column, outer_right_[i]);
    }
    if (left_column > right_column) return;
    MeasureSide(row - pad_rows, outer_left_, left_column, 1, left);
    MeasureSide(row - pad_rows, outer_right_, right_column, -1, right);
    if (!IsOn(main, left, outer_left_, row - pad_rows) ||
        !IsOn(main, right, outer_right_, row - pad_rows)) {
      ++rejected_.two_segments;
      return;
    }
    if (std::min(left.cover, right.cover) < options_.min_cover) {
      ++rejected_.shallow;
      return;
    }
    const std::optional<double> center =
        CenterColumn(0.5 * (left_column + right_column), first, last);
    if (!center) {
      ++rejected_.no_room;
      return;
    }
    const double half_m = (std::max(*center - first, last - *center) + 0.5) * map_.cell_m;
    if (!HasRoom(row, *center, half_m, tips_m, finger_top_)) {
      ++rejected_.no_room;
      return;
    }
    if (At(palm_top_, *center, row) > tips_m + hand_.finger_size_m.z() - clearance_m_) {
      ++rejected_.palm;
      return;
    }
    MeasureDepth(row - pad_rows, tips_m, outer_left_, 1, left);
    MeasureDepth(row - pad_rows, tips_m, outer_right_, -1, right);
    const double engagement_m = std::min(left.engagement_m, right.engagement_m);
    if (engagement_m < options_.min_engagement_m) {
      ++rejected_.shallow;
      return;
    }
    const double antipodal = Antipodal(left, right, right_column - left_column + 1);
    if (antipodal <= 0) {
      ++rejected_.friction;
      return;
    }
    FacePair pair;
    pair.x_m = map_.X_m(*center);
    pair.y_m = map_.Y_m(row);
    pair.tips_m = tips_m;
    pair.width_m = std::min(2 * half_m, hand_.stroke_m - 2 * clearance_m_ - kRounding_m);
    pair.segment = main;
    const double shift_m = std::abs(*center - 0.5 * (left_column + right_column)) * map_.cell_m;
    const bool roomy = HasRoom(row, *center, half_m + options_.good_room_m, tips_m, roomy_top_);
    pair.score = antipodal * std::min(1.0, engagement_m / options_.good_engagement_m) *
                 SupportFactor(left, right) * CoverFactor(left, right) * LeverFactor(main, pair) *
                 HeightFactor(main) * (1 - 0.5 * shift_m / options_.max_shift_m) *
                 (roomy ? 1 : 1 - options_.room_share) * WidthFactor(pair.width_m) * purity_;
    pairs_.push_back(pair);
  }

  // The most frequent segment of the measured cells above the tips between the columns;
  // kBackground if no segment has enough of them. Sets purity_.
  int MainSegment(int row, int pad_rows, double tips_m, int first, int last) {
    counts_.clear();
    int all = 0;
    for (int y = std::max(0, row - pad_rows); y <= std::min(map_.rows - 1, row + pad_rows); ++y) {
      for (int x = first; x <= last; ++x) {
        const int cell = map_.Index(x, y);
        if (!(map_.seen_m[cell] > tips_m)) continue;
        const int segment = map_.segment[cell];
        const auto known = std::find_if(counts_.begin(), counts_.end(),
                                        [&](const auto& c) { return c.first == segment; });
        if (known == counts_.end()) {
          counts_.push_back({segment, 1});
        } else {
          ++known->second;
        }
        ++all;
      }
    }
    if (all == 0) return kBackground;
    const auto largest =
        std::max_element(counts_.begin(), counts_.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    purity_ = static_cast<double>(largest->second) / all;
    if (purity_ < options_.min_purity) {
      ++rejected_.two_segments;
      return kBackground;
    }
    return largest->first;
  }

  // Outermost measured columns above a height in each row of the pads.
  void Silhouette(int row, int pad_rows, double height_m, int first, int last,
                  std::vector<int>& left, std::vector<int>& right) const {
    left.clear();
    right.clear();
    for (int y = row - pad_rows; y <= row + pad_rows; ++y) {
      int from = last + 1, to = first - 1;
      if (y >= 0 && y < map_.rows) {
        const float* seen_m = map_.seen_m.data() + map_.Index(0, y);
        for (from = first; from <= last && !(seen_m[from] > height_m);) ++from;
        for (to = last; to >= first && !(seen_m[to] > height_m);) --to;
      }
      left.push_back(from);
      right.push_back(to);
    }
  }

  // Rows of the contact, its center and the slope of the silhouette. `inward` is the direction
  // from the pad into the object.
  void MeasureSide(int first_row, const std::vector<int>& outer, int column, int inward,
                   Side& side) const {
    constexpr int kTouching = 1;  // cells
    const int face = Cells(options_.near_contact_m);
    double n = 0, sum_y = 0, sum_x = 0, sum_yy = 0, sum_xy = 0;
    for (size_t i = 0; i < outer.size(); ++i) {
      if (outer_left_[i] > outer_right_[i]) continue;  // nothing in this row
      const int depth = inward * (outer[i] - column);
      if (depth < 0 || depth > face) continue;
      const double y = first_row + static_cast<int>(i);
      if (depth <= kTouching) {
        side.rows.push_back(static_cast<int>(y));
        side.center_row += y;
      }
      ++n;
      sum_y += y;
      sum_x += depth;
      sum_yy += y * y;
      sum_xy += y * depth;
    }
    side.center_row /= static_cast<double>(side.rows.size());
    side.cover = n / static_cast<double>(outer.size());
    const double spread = n * sum_yy - sum_y * sum_y;
    side.slope = spread > 0 ? (n * sum_xy - sum_y * sum_x) / spread : 0;
  }

  bool IsOn(int segment, const Side& side, const std::vector<int>& outer, int first_row) const {
    int on = 0;
    for (const int row : side.rows) {
      on += map_.segment[map_.Index(outer[row - first_row], row)] == segment;
    }
    return 2 * on > static_cast<int>(side.rows.size());
  }

  // Height of the surface behind the contact, and the lean of the face.
  void MeasureDepth(int first_row, double tips_m, const std::vector<int>& outer, int inward,
                    Side& side) const {
    const int behind = Cells(0.006);
    double sum_m = 0;
    for (const int row : side.rows) {
      const int column = outer[row - first_row];
      float top_m = map_.seen_m[map_.Index(column, row)];
      for (int k = 1; k <= behind; ++k) {
        const int x = column + inward * k;
        if (map_.Contains(x, row)) top_m = std::max(top_m, map_.seen_m[map_.Index(x, row)]);
      }
      sum_m += top_m - tips_m;
    }
    side.engagement_m = sum_m / static_cast<double>(side.rows.size());
    const double rise_m = std::clamp(0.6 * side.engagement_m, 0.002, 0.006);
    double lean = 0;
    for (const int row : side.rows)
      lean += Lean(outer[row - first_row], row, inward, tips_m + rise_m);
    side.lean = lean / static_cast<double>(side.rows.size());
  }

  // Retreat of the surface per height, from the outermost column up to a height.
  double Lean(int column, int row, int inward, double height_m) const {
    const int max_steps = Cells(0.010);
    constexpr double kMinRise_m = 0.001;
    const double start_m = map_.seen_m[map_.Index(column, row)];
    double before_m = start_m;
    for (int steps = 0; steps < max_steps; ++steps) {
      const int x = column + inward * steps;
      if (!map_.Contains(x, row)) break;
      const double here_m = map_.seen_m[map_.Index(x, row)];
      if (here_m > height_m) {
        if (steps == 0) return 0;
        const double last_step = (height_m - before_m) / (here_m - before_m);
        return (steps - 1 + last_step) * map_.cell_m / std::max(kMinRise_m, height_m - start_m);
      }
      if (std::isfinite(here_m)) before_m = here_m;
    }
    return max_steps * map_.cell_m / std::max(kMinRise_m, height_m - start_m);
  }

  // Quality of the pair in the friction cones, 0..1; 0 = outside of one.
  double Antipodal(const Side& left, const Side& right, int columns) const {
    const auto in_cone = [&](double tangent, double limit) {
      const double share = std::atan(std::abs(tangent)) / std::atan(limit);
      return std::max(0.0, 1 - share * share);
    };
    // Flat contacts that face each other touch along a line, so that the pair has no lever.
    int common = 0;
    for (const int row : left.rows) {
      common += std::find(right.rows.begin(), right.rows.end(), row) != right.rows.end();
    }
    const double offset = common >= 3 ? 0 : (left.center_row - right.center_row) / columns;
    // The slope of a face that is seen from above has less accuracy than its silhouette.
    const double lean_limit = friction_ + options_.lean_margin;
    return in_cone(left.slope, friction_) * in_cone(right.slope, friction_) *
           in_cone(offset, friction_) * in_cone(left.lean, lean_limit) *
           in_cone(right.lean, lean_limit);
  }

  double SupportFactor(const Side& left, const Side& right) const {
    const double rows = static_cast<double>(std::min(left.rows.size(), right.rows.size()));
    return 0.4 + 0.6 * std::min(1.0, rows * map_.cell_m / options_.good_support_m);
  }

  double WidthFactor(double width_m) const {
    const double share = width_m / hand_.stroke_m;
    return 1 - options_.width_share * share * share;
  }

  double CoverFactor(const Side& left, const Side& right) const {
    return std::min(1.0, std::min(left.cover, right.cover) / options_.good_cover);
  }

  double LeverFactor(int segment, const FacePair& pair) const {
    const double dx_m = centers_G_[segment].x() - pair.x_m,
                 dy_m = centers_G_[segment].y() - pair.y_m;
    const double lever = std::hypot(0.7 * dx_m, dy_m) / options_.lever_m;
    return 1 / (1 + lever * lever);
  }

  double HeightFactor(int segment) const {
    const double range_m = top_B_m_ - bottom_B_m_;
    if (!(range_m > 0)) return 1;
    return 1 - options_.height_share * (top_B_m_ - segments_[segment].top_m) / range_m;
  }

  // The column nearest to the center of the contacts at which the hand encloses the blocked
  // columns within its stroke.
  std::optional<double> CenterColumn(double contacts, int first, int last) const {
    const double half = (0.5 * hand_.stroke_m - options_.tight_clearance_m) / map_.cell_m - 0.5;
    const double low = last - half, high = first + half;
    if (low > high) return std::nullopt;
    const double center = std::clamp(contacts, low, high);
    if (std::abs(center - contacts) * map_.cell_m > options_.max_shift_m) return std::nullopt;
    return center;
  }

  float At(const std::vector<float>& values, double column, int row) const {
    const int x = static_cast<int>(std::lround(column));
    return map_.Contains(x, row) ? values[map_.Index(x, row)]
                                 : -std::numeric_limits<float>::infinity();
  }

  // Whether both open fingers are above all of the surface.
  bool HasRoom(int row, double center, double half_m, double tips_m,
               const std::vector<float>& top) const {
    const double enclosed_m = std::min(half_m + clearance_m_, 0.5 * hand_.stroke_m);
    const double to_finger = (enclosed_m + 0.5 * hand_.finger_size_m.x()) / map_.cell_m;
    const double limit_m = tips_m - options_.below_tips_m;
    return At(top, center - to_finger, row) <= limit_m &&
           At(top, center + to_finger, row) <= limit_m;
  }

  const HeightMap& map_;
  const std::vector<SurfaceSegment>& segments_;
  const sim::HandSpec& hand_;
  const double clearance_m_, friction_;
  const OpposingFacesOptions& options_;
  FaceRejections& rejected_;
  double lowest_m_ = std::numeric_limits<double>::infinity();
  double highest_m_ = -std::numeric_limits<double>::infinity();
  double top_B_m_ = -std::numeric_limits<double>::infinity();
  double bottom_B_m_ = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector3d> centers_G_;  // by segment
  // Largest solid height under a pad, a finger, a finger with room around it, and the palm, each
  // centered at the cell.
  std::vector<float> pad_top_, finger_top_, roomy_top_, palm_top_;
  std::vector<BlockedRun> runs_;
  std::vector<int> outer_left_, outer_right_;
  std::vector<std::pair<int, int>> counts_;  // cells by segment
  double purity_ = 0;
  std::vector<FacePair> pairs_;
};

}  // namespace

void FaceRejections::Add(const FaceRejections& other) {
  no_room += other.no_room;
  palm += other.palm;
  two_segments += other.two_segments;
  friction += other.friction;
  shallow += other.shallow;
}

void OpposingFacesOptions::Visit(SettingsVisitor& v) {
  const Range length{0.0005, 0.2}, share{0, 1};
  v.Real("cell_m", cell_m, length, "edge of a cell of the height map, m");
  v.Real("row_step_m", row_step_m, length, "distance of the slices, m");
  v.Real("level_step_m", level_step_m, length, "distance of the heights of the finger tips, m");
  v.Real("floor_gap_m", floor_gap_m, {0, 0.1}, "height of the lowest tips above the surface, m");
  v.Real("below_tips_m", below_tips_m, {0, 0.1},
         "surface this far below the tips does not block them, m");
  v.Real("min_engagement_m", min_engagement_m, length,
         "minimum height of measured surface above the tips, m");
  v.Real("good_engagement_m", good_engagement_m, length,
         "height of measured surface above the tips without loss, m");
  v.Real("good_support_m", good_support_m, length,
         "width of a contact from which there is no loss, m");
  v.Real("min_cover", min_cover, share,
         "minimum share of the rows of a pad with surface near its contact");
  v.Real("good_cover", good_cover, {0.01, 1},
         "share of the rows of a pad with surface near its contact without loss");
  v.Real("near_contact_m", near_contact_m, length,
         "depth of the surface behind the contact that counts as near, m");
  v.Real("tight_clearance_m", tight_clearance_m, {0, 0.1}, "free space beside a wide object, m");
  v.Real("min_purity", min_purity, share, "minimum share of one segment between the pads");
  v.Real("lever_m", lever_m, length,
         "distance from the center of the segment that halves the score, m");
  v.Real("max_shift_m", max_shift_m, length,
         "maximum shift of the hand from the middle of the contacts towards free space, m");
  v.Real("good_room_m", good_room_m, {0, 0.1}, "free space beside the fingers without loss, m");
  v.Real("lean_margin", lean_margin, {0, 1},
         "tolerance of the slope of a face against the approach, beyond the friction coefficient");
  v.Real("room_share", room_share, share,
         "share of the score that is lost without free space beside the fingers");
  v.Real("width_share", width_share, share, "share of the score that is lost at the full stroke");
  v.Real("height_share", height_share, share, "share of the score that the lowest segment loses");
}

std::vector<FacePair> FindFacePairs(const HeightMap& map,
                                    const std::vector<SurfaceSegment>& segments,
                                    const sim::HandSpec& hand, double clearance_m, double friction,
                                    const OpposingFacesOptions& options, FaceRejections& rejected) {
  return SliceSearch(map, segments, hand, clearance_m, friction, options, rejected).FindPairs();
}

}  // namespace pickbed::grasp
