#include "perception/crop_methods/crop_conditions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pickbed::perception {
namespace {

constexpr CropCondition kConditions[] = {
    {"clean", "an ideal sensor and an isolated object"},
    {"noisy", "the noise, holes and edges of a real sensor", true},
    {"relit", "other lamps and materials", false, true},
    {"background", "other instances beside and behind, and a wall", false, false, true},
    {"occluded_10", "a tenth hidden by another instance", false, false, false, 0.1},
    {"occluded_20", "a fifth hidden", false, false, false, 0.2},
    {"occluded_30", "three tenths hidden", false, false, false, 0.3},
    {"occluded_50", "half hidden", false, false, false, 0.5},
};

constexpr double kWider = 2;          // widens a neighbour's image, so that it shows all of it
constexpr int kMaxSamples = 12;       // maximum number of occluders sampled per view
constexpr double kNearEnough = 0.02;  // tolerance of the hidden share
constexpr int kNeighbours = 3;        // in the background of a view

// Maximum ratio of the diameters of object and neighbour, so that a neighbour is neither a speck
// nor a wall.
constexpr double kSimilarSize = 1.7;

ObjectId SimilarObject(const ObjectSet& objects, ObjectId object, Rng& rng) {
  std::vector<ObjectId> similar;
  for (ObjectId other{0}; other < static_cast<int>(objects.size()); ++other) {
    const double ratio = objects[other]->diameter_m / objects[object]->diameter_m;
    if (other != object && ratio < kSimilarSize && ratio > 1 / kSimilarSize)
      similar.push_back(other);
  }
  return similar.empty() ? object : similar[rng.Index(static_cast<int>(similar.size()))];
}

// Renders another object on the optical axis, just before `object` (side -1) or behind it (side 1).
LabelledView Neighbour(const CropSources& sources, ObjectId object, double side,
                       const CropViewOptions& options, Rng& rng) {
  const ObjectSet& objects = sources.clean->objects();
  const ObjectId other = SimilarObject(objects, object, rng);
  const double apart_m = 0.5 * (objects[object]->diameter_m + objects[other]->diameter_m);
  const double z_m = options.distance_diameters * objects[object]->diameter_m + side * apart_m;
  const Eigen::Matrix3d R_CO = rng.Rotation().toRotationMatrix();
  const Pose X_CO =
      MakePose(R_CO, Eigen::Vector3d(0, 0, z_m) - R_CO * CropCenter_O(*objects[other]));
  return sources.clean->Isolated(other, {X_CO}, CropCamera(options, kWider), rng.Next())[0];
}

// Calls visit(x, y, from_x, from_y) for the pixels of `view` that the shifted neighbour covers.
// Both images are centered on the optical axis.
template <typename Visit>
void ForCovered(const LabelledView& view, const LabelledView& neighbour, int dx, int dy,
                const Visit& visit) {
  const int left = (neighbour.ids.width() - view.ids.width()) / 2 - dx;
  const int top = (neighbour.ids.height() - view.ids.height()) / 2 - dy;
  for (int y = 0; y < view.ids.height(); ++y) {
    for (int x = 0; x < view.ids.width(); ++x) {
      if (!neighbour.ids.Contains(x + left, y + top) || neighbour.ids(x + left, y + top) == 0) {
        continue;
      }
      visit(x, y, x + left, y + top);
    }
  }
}

int CoveredPixels(const LabelledView& view, const LabelledView& neighbour, int dx, int dy) {
  int covered = 0;
  ForCovered(view, neighbour, dx, dy, [&](int x, int y, int, int) { covered += view.ids(x, y); });
  return covered;
}

// Draws the neighbour where it is nearer than what the view shows.
void Draw(const LabelledView& neighbour, int dx, int dy, LabelledView& view) {
  ForCovered(view, neighbour, dx, dy, [&](int x, int y, int from_x, int from_y) {
    const float depth_m = neighbour.frame.depth_m(from_x, from_y);
    const float shown_m = view.frame.depth_m(x, y);
    if (depth_m <= 0 || (shown_m > 0 && shown_m <= depth_m)) return;
    view.frame.depth_m(x, y) = depth_m;
    if (!view.frame.color.empty()) {
      view.frame.color(x, y) = neighbour.frame.color(from_x, from_y);
    }
    view.ids(x, y) = 0;
  });
}

int ObjectPixels(const LabelledView& view) {
  return static_cast<int>(std::count(view.ids.pixels().begin(), view.ids.pixels().end(), 1));
}

struct Cover {
  LabelledView blocker;
  int dx = 0, dy = 0;  // px
  double hidden = 0;   // share of the object's pixels
};

// Moves the blocker towards the object from a random direction until it hides the share.
Cover SlideIn(const LabelledView& view, LabelledView blocker, double share, Rng& rng) {
  const double pixels = ObjectPixels(view);
  const double angle_rad = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  Cover cover{std::move(blocker)};
  for (int distance = view.ids.width() * 3 / 2; distance >= 0; --distance) {
    cover.dx = static_cast<int>(std::lround(distance * std::cos(angle_rad)));
    cover.dy = static_cast<int>(std::lround(distance * std::sin(angle_rad)));
    cover.hidden = CoveredPixels(view, cover.blocker, cover.dx, cover.dy) / pixels;
    if (cover.hidden >= share) break;
  }
  return cover;
}

double Occlude(const CropSources& sources, ObjectId object, double share,
               const CropViewOptions& options, Rng& rng, LabelledView& view) {
  Cover best;
  for (int i = 0; i < kMaxSamples; ++i) {
    Cover cover = SlideIn(view, Neighbour(sources, object, -1, options, rng), share, rng);
    const bool is_better = std::abs(cover.hidden - share) < std::abs(best.hidden - share);
    if (i == 0 || is_better) best = std::move(cover);
    if (std::abs(best.hidden - share) <= kNearEnough) break;
  }
  Draw(best.blocker, best.dx, best.dy, view);
  return best.hidden;
}

// Draws a tilted plane in the empty pixels. Its color changes in brightness to one side.
void DrawWall(double z_m, Rng& rng, LabelledView& view) {
  constexpr double kSteepest = 0.5;
  const double slope_x = rng.Uniform(-kSteepest, kSteepest);
  const double slope_y = rng.Uniform(-kSteepest, kSteepest);
  const Eigen::Vector3d color(rng.Uniform(40, 220), rng.Uniform(40, 220), rng.Uniform(40, 220));
  const CameraIntrinsics& k = view.frame.intrinsics;
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      if (view.frame.depth_m(x, y) > 0) continue;
      const double u = (x - k.cx()) / k.fx(), v = (y - k.cy()) / k.fy();
      view.frame.depth_m(x, y) = static_cast<float>(z_m / (1 - slope_x * u - slope_y * v));
      const Eigen::Vector3d shade = color * (1 + slope_x * x / k.width());
      const auto byte = [](double c) { return static_cast<uint8_t>(std::clamp(c, 0.0, 255.0)); };
      if (!view.frame.color.empty()) {
        view.frame.color(x, y) = {byte(shade.x()), byte(shade.y()), byte(shade.z())};
      }
    }
  }
}

void DrawBackground(const CropSources& sources, ObjectId object, const CropViewOptions& options,
                    Rng& rng, LabelledView& view) {
  const double diameter_m = sources.clean->objects()[object]->diameter_m;
  for (int i = 0; i < kNeighbours; ++i) {
    const LabelledView neighbour = Neighbour(sources, object, 1, options, rng);
    const int reach_px = view.ids.width() / 2;
    const int dx = static_cast<int>(std::lround(rng.Uniform(-reach_px, reach_px)));
    Draw(neighbour, dx, static_cast<int>(std::lround(rng.Uniform(-reach_px, reach_px))), view);
  }
  DrawWall((options.distance_diameters + rng.Uniform(0.6, 1)) * diameter_m, rng, view);
}

}  // namespace

std::span<const CropCondition> CropConditionTable() { return kConditions; }

std::vector<CropTest> MakeCropTests(const CropSources& sources, ObjectId object,
                                    const CropCondition& condition, const Rotations& R_CO,
                                    const CropViewOptions& options, uint64_t seed) {
  LabelledViewSource& source = condition.noisy   ? *sources.noisy
                               : condition.relit ? *sources.relit
                                                 : *sources.clean;
  std::vector<Pose> X_CO;
  for (const Eigen::Matrix3d& R : R_CO) {
    X_CO.push_back(CropPose(*source.objects()[object], R, options));
  }
  std::vector<LabelledView> views = source.Isolated(object, X_CO, CropCamera(options), seed);
  std::vector<CropTest> tests;
  for (size_t i = 0; i < views.size(); ++i) {
    Rng rng = Rng::Derive(seed, i, "crop test");
    double hidden = 0;
    if (condition.occluded > 0) {
      hidden = Occlude(sources, object, condition.occluded, options, rng, views[i]);
    }
    if (condition.background) DrawBackground(sources, object, options, rng, views[i]);
    tests.push_back({std::move(views[i].frame), X_CO[i], hidden});
  }
  return tests;
}

}  // namespace pickbed::perception
