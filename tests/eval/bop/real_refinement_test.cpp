// Refinement on a real frame: five household objects in front of a consumer depth camera. The tests
// are skipped if the frame is absent; bidirectional_icp_test.cpp tests the same code on synthetic
// scenes.
//
// The published poses come from a video annotation and are not exact. The color image, which
// refinement does not use, shows the drill 7 mm beside its published pose. The can rests on the
// table, but its published axis leans by nearly 4 degrees. The left side of the can is hidden, and
// the sensor shows its right side as if it were flat. Geometry therefore ends 5 mm and 5 degrees
// from the published pose, and color is between the two. So the tests require that each object
// converges to one pose from all starts. For mustard and banana this is the published pose. For the
// drill it is the published pose moved to where the color image shows the drill.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "eval/bop/layout.h"
#include "eval/bop/read_dataset.h"
#include "perception/cloud/background_fit.h"
#include "perception/icp/bidirectional_icp.h"
#include "scenes/geometry/symmetry_finder.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = fs::path(PICKBED_TEST_DATA) / "bop_ycbv_mini";
constexpr int kStarts = 20;
constexpr int kNeeded = 16;  // 80 % of them
constexpr int kCan = 4, kMustard = 5, kBanana = 10, kDrill = 15;

struct PoseError {
  double ray_m = std::numeric_limits<double>::infinity();  // of the center, along the ray
  double across_m = ray_m;
  double angle_deg = ray_m;
  // Returns the largest of the three errors, in multiples of its tolerance.
  double Tolerances() const { return std::max({ray_m / 0.006, across_m / 0.003, angle_deg / 3}); }
  bool small() const { return Tolerances() <= 1; }
};

struct RealObject {
  int id = 0;
  std::shared_ptr<const ObjectModel> model;
  ModelPoints points;
  std::vector<Pose> symmetries_O;
  Pose published_X_CO;

  PoseError Error(const Pose& X_CO, const Pose& truth_X_CO) const {
    const Eigen::Vector3d center_O = points.center_O.cast<double>();
    const Eigen::Vector3d ray = (truth_X_CO * center_O).normalized();
    PoseError smallest;
    for (const Pose& S : symmetries_O) {
      const Pose X = truth_X_CO * S;
      const Eigen::Vector3d off = X_CO * center_O - X * center_O;
      const PoseError error{std::abs(off.dot(ray)), (off - off.dot(ray) * ray).norm(),
                            RotationAngleRad(X_CO.linear(), X.linear()) * 180 / std::numbers::pi};
      if (error.Tolerances() < smallest.Tolerances()) smallest = error;
    }
    return smallest;
  }
};

class RealRefinement : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!fs::exists(kRoot / "models")) return;
    const auto infos = ReadModelsInfo(kRoot / "models", ThrowFault);
    const SceneTruth scene = ReadSceneTruth(kRoot / "test" / "000001", 1, ThrowFault);
    const ImageTruth& image = scene.images.at(0);
    frame_ = ReadFrame(scene, image);
    cloud_ = BuildCloud(frame_, std::nullopt);
    for (size_t i = 0; i < image.instances.size(); ++i) {
      if (image.infos.at(i).visib_fract < 0.6) continue;
      RealObject object;
      object.id = image.instances[i].object_id;
      object.model =
          LoadDatasetModel(kRoot / "models", object.id, infos.at(object.id), ModelName(object.id));
      object.points = MakeModelPoints(*object.model);
      // The dataset declares no symmetry for the can because of its label. Its scan is round to 4 %
      // of the diameter, and without color its rotation about the axis cannot be seen.
      object.symmetries_O =
          SymmetryTransforms(FindSymmetries(object.model->mesh_O, {.tolerance_diameters = 0.04}));
      object.published_X_CO = image.instances[i].X_CO;
      object.published_X_CO.linear() = Orthonormalized(object.published_X_CO.linear());
      objects_.push_back(std::move(object));
    }
  }
  void SetUp() override {
    if (objects_.empty()) GTEST_SKIP() << "no " << kRoot;
  }
  static void TearDownTestSuite() { objects_.clear(); }

  // The published pose, rotated by 10 degrees about the object's origin and moved by 10 mm.
  static Pose Start(const RealObject& object, int start) {
    Rng rng = Rng::Derive(0, object.id, fmt::format("real_refinement/{}", start));
    const Eigen::Vector3d axis = rng.UnitVector();
    return Perturbed(object.published_X_CO, axis, 10, 0.010 * rng.UnitVector());
  }
  static std::vector<Pose> FromAllStarts(const RealObject& object,
                                         const BidirectionalIcpOptions& options = {}) {
    std::vector<Pose> poses;
    for (int i = 0; i < kStarts; ++i) {
      poses.push_back(BidirectionalIcp(cloud_, object.points, Start(object, i), options).X_CO);
    }
    return poses;
  }
  static int CountSmall(const RealObject& object, const std::vector<Pose>& poses,
                        const Pose& truth_X_CO) {
    return static_cast<int>(std::count_if(poses.begin(), poses.end(), [&](const Pose& X_CO) {
      return object.Error(X_CO, truth_X_CO).small();
    }));
  }

  static RgbdFrame frame_;
  static OrganizedCloud cloud_;
  static std::vector<RealObject> objects_;
};

RgbdFrame RealRefinement::frame_;
OrganizedCloud RealRefinement::cloud_;
std::vector<RealObject> RealRefinement::objects_;

TEST_F(RealRefinement, UsesTheMostlyVisibleObjects) {
  std::vector<int> ids;
  for (const RealObject& object : objects_) ids.push_back(object.id);
  EXPECT_EQ(ids, (std::vector<int>{kCan, kMustard, kBanana, kDrill}));
}

TEST_F(RealRefinement, EachObjectConvergesToOnePose) {
  for (const RealObject& object : objects_) {
    const IcpResult home = BidirectionalIcp(cloud_, object.points, object.published_X_CO);
    EXPECT_EQ(home.status, IcpStatus::kRefined) << object.id;
    EXPECT_GT(home.reciprocal_condition_number, 1e-3) << object.id;
    EXPECT_GE(CountSmall(object, FromAllStarts(object), home.X_CO), kNeeded) << object.id;
  }
}

TEST_F(RealRefinement, MustardAndBananaConvergeToThePublishedPose) {
  for (const RealObject& object : objects_) {
    const int back = CountSmall(object, FromAllStarts(object), object.published_X_CO);
    const PoseError home = object.Error(
        BidirectionalIcp(cloud_, object.points, object.published_X_CO).X_CO, object.published_X_CO);
    RecordProperty(fmt::format("object_{}_of_{}", object.id, kStarts), back);
    RecordProperty(fmt::format("object_{}_off", object.id),
                   fmt::format("{:.1f} mm along, {:.1f} mm across, {:.1f} deg", 1e3 * home.ray_m,
                               1e3 * home.across_m, home.angle_deg));
    if (object.id == kMustard || object.id == kBanana) {
      EXPECT_GE(back, kNeeded) << object.id;
    }
  }
}

TEST_F(RealRefinement, NoStartIsRightWithoutRefinement) {
  BidirectionalIcpOptions off;
  off.iterations = 0;
  off.restart_rad = 0;
  for (const RealObject& object : objects_) {
    EXPECT_EQ(CountSmall(object, FromAllStarts(object, off), object.published_X_CO), 0)
        << object.id;
  }
}

// An object upright on the table is upright in its published pose if that pose is right. The bottle
// is, to two degrees. The can leans by more than three, so no refinement can be right for both.
TEST_F(RealRefinement, PublishedPoseOfTheCanLeans) {
  constexpr int kStride = 8;
  std::vector<Eigen::Vector3f> points_C;
  for (size_t i = 0; i < cloud_.points_C.size(); i += kStride) {
    if (cloud_.depth_m.data()[i] > 0) points_C.push_back(cloud_.points_C[i]);
  }
  const std::vector<BackgroundPlane> planes = FitBackground(points_C, {});
  ASSERT_FALSE(planes.empty());
  const Eigen::Vector3d up_C = planes.back().normal_C.cast<double>();
  const auto lean_deg = [&](int id) {
    const auto object = std::find_if(objects_.begin(), objects_.end(),
                                     [&](const RealObject& other) { return other.id == id; });
    const double cosine = object->published_X_CO.linear().col(2).dot(up_C);
    return std::acos(std::min(1.0, std::abs(cosine))) * 180 / std::numbers::pi;
  };
  RecordProperty("can_leans_deg", fmt::format("{:.1f}", lean_deg(kCan)));
  RecordProperty("mustard_leans_deg", fmt::format("{:.1f}", lean_deg(kMustard)));
  EXPECT_LT(lean_deg(kMustard), 3);
  EXPECT_GT(lean_deg(kCan), 3) << "the published pose is right: require it";
}

// Color contrast across the outline of an object.
class ColorOutline {
 public:
  ColorOutline(const RgbdFrame& frame, const RealObject& object, const Pose& X_CO) : frame_(frame) {
    SyntheticDepth isolated(frame.intrinsics);
    isolated.AddMesh(object.model->mesh_O, X_CO);
    const Image<float>& depth_m = isolated.frame().depth_m;
    constexpr int kReach = 3;
    for (int y = kReach; y < depth_m.height() - kReach; ++y) {
      for (int x = kReach; x < depth_m.width() - kReach; ++x) {
        if (depth_m(x, y) > 0 && OnOutline(depth_m, x, y)) AddPoint(depth_m, x, y);
      }
    }
  }

  // Returns the mean contrast across the outline, moved by (dx, dy) px.
  double Contrast(int dx, int dy) const {
    double sum = 0;
    for (const Point& p : points_) {
      sum += (Color(p.pixel + 2.5 * p.outward, dx, dy) - Color(p.pixel - 2.5 * p.outward, dx, dy))
                 .norm();
    }
    return points_.empty() ? 0.0 : sum / static_cast<double>(points_.size());
  }

  // Returns the move of at most `reach` px in x and y with the greatest contrast.
  Eigen::Vector2i BestMove(int reach) const {
    Eigen::Vector2i best(0, 0);
    double best_contrast = -1;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const double contrast = Contrast(dx, dy);
        if (contrast <= best_contrast) continue;
        best_contrast = contrast;
        best = {dx, dy};
      }
    }
    return best;
  }

 private:
  struct Point {
    Eigen::Vector2d pixel, outward;
  };

  static bool OnOutline(const Image<float>& depth_m, int x, int y) {
    return !(depth_m(x - 1, y) > 0 && depth_m(x + 1, y) > 0 && depth_m(x, y - 1) > 0 &&
             depth_m(x, y + 1) > 0);
  }
  // Adds an outline point unless something occludes it.
  void AddPoint(const Image<float>& depth_m, int x, int y) {
    Eigen::Vector2d outward = Eigen::Vector2d::Zero();
    float nearest_m = std::numeric_limits<float>::max();
    for (int v = -3; v <= 3; ++v) {
      for (int u = -3; u <= 3; ++u) {
        if (depth_m(x + u, y + v) > 0) outward -= Eigen::Vector2d(u, v);
        const float seen_m = frame_.depth_m(x + u, y + v);
        if (seen_m > 0) nearest_m = std::min(nearest_m, seen_m);
      }
    }
    if (nearest_m < depth_m(x, y) - 0.03f || outward.isZero()) return;
    points_.push_back({Eigen::Vector2d(x, y), outward.normalized()});
  }
  // Returns the mean color of 5 x 5 pixels.
  Eigen::Vector3d Color(const Eigen::Vector2d& at, int dx, int dy) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int v = -2; v <= 2; ++v) {
      for (int u = -2; u <= 2; ++u) {
        const int x = static_cast<int>(std::lround(at.x())) + dx + u;
        const int y = static_cast<int>(std::lround(at.y())) + dy + v;
        const Rgb8 c = frame_.color(std::clamp(x, 0, frame_.color.width() - 1),
                                    std::clamp(y, 0, frame_.color.height() - 1));
        sum += Eigen::Vector3d(c.r, c.g, c.b) / 25;
      }
    }
    return sum;
  }

  const RgbdFrame& frame_;
  std::vector<Point> points_;
};

// The published pose of the drill does not cover the drill in the color image. It is moved across
// the viewing ray to where its outline has the most contrast. The result is a ground truth that
// does not depend on the depth image.
TEST_F(RealRefinement, DrillConvergesToItsPlaceInTheColorImage) {
  const auto drill = std::find_if(objects_.begin(), objects_.end(),
                                  [](const RealObject& object) { return object.id == kDrill; });
  ASSERT_NE(drill, objects_.end());
  const ColorOutline outline(frame_, *drill, drill->published_X_CO);
  const Eigen::Vector2i move_px = outline.BestMove(12);
  EXPECT_GT(outline.Contrast(move_px.x(), move_px.y()), 1.3 * outline.Contrast(0, 0));
  const double z_m = (drill->published_X_CO * drill->points.center_O.cast<double>()).z();
  Pose truth = drill->published_X_CO;
  truth.translation().x() += move_px.x() * z_m / frame_.intrinsics.fx();
  truth.translation().y() += move_px.y() * z_m / frame_.intrinsics.fy();
  const PoseError published = drill->Error(drill->published_X_CO, truth);
  RecordProperty("published_off_across_mm", fmt::format("{:.1f}", 1e3 * published.across_m));
  EXPECT_GT(published.across_m, 0.003) << "the published pose is right: require it";
  const int back = CountSmall(*drill, FromAllStarts(*drill), truth);
  RecordProperty(fmt::format("moved_truth_of_{}", kStarts), back);
  EXPECT_GE(back, kNeeded) << "moved by " << move_px.transpose() << " px";
}

// The outline of the refined pose follows stronger edges of the color image than the published
// one. Refinement does not use color. The can is an exception, see the head of this file.
TEST_F(RealRefinement, ColorEdgesSupportTheRefinedPose) {
  for (const RealObject& object : objects_) {
    const Pose X_CO = BidirectionalIcp(cloud_, object.points, object.published_X_CO).X_CO;
    const double published = ColorOutline(frame_, object, object.published_X_CO).Contrast(0, 0);
    const double refined = ColorOutline(frame_, object, X_CO).Contrast(0, 0);
    RecordProperty(fmt::format("contrast_{}", object.id),
                   fmt::format("{:.1f} -> {:.1f}", published, refined));
    if (object.id != kCan) {
      EXPECT_GT(refined, 1.1 * published) << object.id;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
