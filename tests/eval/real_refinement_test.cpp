// Refinement on a real frame: five household objects before a consumer's depth camera. Skipped
// where the frame is absent; two_way_icp_test.cpp tests the same code on made scenes.
//
// The published poses are those of a video annotation and not exact. The colour image, which
// refinement does not see, shows the drill 7 mm beside its published pose. The can stands on the
// table, from which its published axis leans by nearly 4 degrees; its left is hidden and the sensor
// gives its right as if it were flat, so that geometry alone ends 5 mm and 5 degrees from the
// published pose, and colour lies between the two. So it is asked that each object
// comes back to one pose from everywhere; that it is the published one for mustard and banana; and
// that for the drill it is where colour moves the published one to.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "eval/bop/dataset.h"
#include "eval/bop/layout.h"
#include "perception/fitted_background.h"
#include "perception/two_way_icp.h"
#include "scenes/symmetry_finder.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = fs::path(PICKBED_TEST_DATA) / "bop_ycbv_mini";
constexpr int kStarts = 20;
constexpr int kNeeded = 16;  // 80 % of them
constexpr int kCan = 4, kMustard = 5, kBanana = 10, kDrill = 15;

struct PoseError {
  double ray_m = std::numeric_limits<double>::infinity();  // of the part's centre
  double across_m = ray_m;
  double angle_deg = ray_m;
  // How many times the tolerance of the worst of the three.
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
    PoseError least;
    for (const Pose& S : symmetries_O) {
      const Pose X = truth_X_CO * S;
      const Eigen::Vector3d off = X_CO * center_O - X * center_O;
      const PoseError error{std::abs(off.dot(ray)), (off - off.dot(ray) * ray).norm(),
                            RotationAngleRad(X_CO.linear(), X.linear()) * 180 / std::numbers::pi};
      if (error.Tolerances() < least.Tolerances()) least = error;
    }
    return least;
  }
};

class RealRefinement : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!fs::exists(kRoot / "models")) return;
    const auto infos = bop::ReadModelsInfo(kRoot / "models", bop::ThrowFault);
    const bop::SceneTruth scene =
        bop::ReadSceneTruth(kRoot / "test" / "000001", 1, bop::ThrowFault);
    const bop::ImageTruth& image = scene.images.at(0);
    frame_ = bop::ReadFrame(scene, image);
    cloud_ = BuildCloud(frame_, std::nullopt);
    for (size_t i = 0; i < image.instances.size(); ++i) {
      if (image.infos.at(i).visib_fract < 0.6) continue;
      RealObject object;
      object.id = image.instances[i].object_id;
      object.model = bop::LoadModel(kRoot / "models", object.id, infos.at(object.id),
                                    bop::ModelName(object.id));
      object.points = MakeModelPoints(*object.model);
      // The can is declared to have no symmetry for its label's sake, and its scan is round to 4 %
      // of the diameter; without colour its turn about the axis cannot be seen.
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

  // Turned by 10 degrees about the part's origin and moved by 10 mm.
  static Pose Start(const RealObject& object, int start) {
    Rng rng = Rng::Derive(0, object.id, fmt::format("real_refinement/{}", start));
    const Eigen::Vector3d axis = rng.UnitVector();
    return Perturbed(object.published_X_CO, axis, 10, 0.010 * rng.UnitVector());
  }
  static std::vector<Pose> FromAllStarts(const RealObject& object,
                                         const TwoWayIcpOptions& options = {}) {
    std::vector<Pose> poses;
    for (int i = 0; i < kStarts; ++i) {
      poses.push_back(TwoWayIcp(cloud_, object.points, Start(object, i), options).X_CO);
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

TEST_F(RealRefinement, FindsTheObjectsThatAreMostlyVisible) {
  std::vector<int> ids;
  for (const RealObject& object : objects_) ids.push_back(object.id);
  EXPECT_EQ(ids, (std::vector<int>{kCan, kMustard, kBanana, kDrill}));
}

TEST_F(RealRefinement, EachObjectComesBackToOnePose) {
  for (const RealObject& object : objects_) {
    const TwoWayReport home = TwoWayIcp(cloud_, object.points, object.published_X_CO);
    EXPECT_FALSE(home.made_worse) << object.id;
    EXPECT_GT(home.conditioning, 1e-3) << object.id;
    EXPECT_GE(CountSmall(object, FromAllStarts(object), home.X_CO), kNeeded) << object.id;
  }
}

TEST_F(RealRefinement, MustardAndBananaComeBackToThePublishedPose) {
  for (const RealObject& object : objects_) {
    const int back = CountSmall(object, FromAllStarts(object), object.published_X_CO);
    const PoseError home = object.Error(
        TwoWayIcp(cloud_, object.points, object.published_X_CO).X_CO, object.published_X_CO);
    RecordProperty(fmt::format("object_{}_of_{}", object.id, kStarts), back);
    RecordProperty(fmt::format("object_{}_off", object.id),
                   fmt::format("{:.1f} mm along, {:.1f} mm across, {:.1f} deg", 1e3 * home.ray_m,
                               1e3 * home.across_m, home.angle_deg));
    if (object.id == kMustard || object.id == kBanana) {
      EXPECT_GE(back, kNeeded) << object.id;
    }
  }
}

TEST_F(RealRefinement, WithoutRefinementNoStartIsRight) {
  TwoWayIcpOptions off;
  off.iterations = 0;
  off.restart_rad = 0;
  for (const RealObject& object : objects_) {
    EXPECT_EQ(CountSmall(object, FromAllStarts(object, off), object.published_X_CO), 0)
        << object.id;
  }
}

// What stands upright on the table does so in its published pose as far as that is right: the
// bottle to two degrees, the can to no three, so that no refinement can be right by both.
TEST_F(RealRefinement, ThePublishedCanLeansFromTheTable) {
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
  EXPECT_GT(lean_deg(kCan), 3) << "the published pose is right: ask for it";
}

// Colour on both sides of an outline.
class ColourOutline {
 public:
  ColourOutline(const RgbdFrame& frame, const RealObject& object, const Pose& X_CO)
      : frame_(frame) {
    SyntheticDepth alone(frame.intrinsics);
    alone.AddMesh(object.model->mesh_O, X_CO);
    const Image<float>& depth_m = alone.frame().depth_m;
    constexpr int kReach = 3;
    for (int y = kReach; y < depth_m.height() - kReach; ++y) {
      for (int x = kReach; x < depth_m.width() - kReach; ++x) {
        if (depth_m(x, y) > 0 && OnOutline(depth_m, x, y)) AddPoint(depth_m, x, y);
      }
    }
  }

  // Mean contrast across the outline when it is moved by whole pixels.
  double Contrast(int dx, int dy) const {
    double sum = 0;
    for (const Point& p : points_) {
      sum += (Colour(p.pixel + 2.5 * p.outward, dx, dy) - Colour(p.pixel - 2.5 * p.outward, dx, dy))
                 .norm();
    }
    return points_.empty() ? 0.0 : sum / static_cast<double>(points_.size());
  }

  // The move, up to `reach` px each way, at which the contrast is greatest.
  Eigen::Vector2i BestMove(int reach) const {
    Eigen::Vector2i best(0, 0);
    double most = -1;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const double contrast = Contrast(dx, dy);
        if (contrast <= most) continue;
        most = contrast;
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
  // Unless something stands before it.
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
  // Mean of five by five pixels.
  Eigen::Vector3d Colour(const Eigen::Vector2d& at, int dx, int dy) const {
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

// The drill at its published pose does not cover the drill in the colour image. Moved across the
// ray to where its outline has most contrast, it is a truth that owes nothing to the depth image.
TEST_F(RealRefinement, DrillComesBackToWhereTheColourImageShowsIt) {
  const auto drill = std::find_if(objects_.begin(), objects_.end(),
                                  [](const RealObject& object) { return object.id == kDrill; });
  ASSERT_NE(drill, objects_.end());
  const ColourOutline outline(frame_, *drill, drill->published_X_CO);
  const Eigen::Vector2i move_px = outline.BestMove(12);
  EXPECT_GT(outline.Contrast(move_px.x(), move_px.y()), 1.3 * outline.Contrast(0, 0));
  const double z_m = (drill->published_X_CO * drill->points.center_O.cast<double>()).z();
  Pose truth = drill->published_X_CO;
  truth.translation().x() += move_px.x() * z_m / frame_.intrinsics.fx;
  truth.translation().y() += move_px.y() * z_m / frame_.intrinsics.fy;
  const PoseError published = drill->Error(drill->published_X_CO, truth);
  RecordProperty("published_off_across_mm", fmt::format("{:.1f}", 1e3 * published.across_m));
  EXPECT_GT(published.across_m, 0.003) << "the published pose is right: ask for it";
  const int back = CountSmall(*drill, FromAllStarts(*drill), truth);
  RecordProperty(fmt::format("moved_truth_of_{}", kStarts), back);
  EXPECT_GE(back, kNeeded) << "moved by " << move_px.transpose() << " px";
}

// The outline of the refined pose lies on stronger edges of the colour image than that of the
// published one, of which refinement saw nothing; not so for the can, see above.
TEST_F(RealRefinement, ColourAgreesWithTheRefinedPose) {
  for (const RealObject& object : objects_) {
    const Pose X_CO = TwoWayIcp(cloud_, object.points, object.published_X_CO).X_CO;
    const double published = ColourOutline(frame_, object, object.published_X_CO).Contrast(0, 0);
    const double refined = ColourOutline(frame_, object, X_CO).Contrast(0, 0);
    RecordProperty(fmt::format("contrast_{}", object.id),
                   fmt::format("{:.1f} -> {:.1f}", published, refined));
    if (object.id != kCan) {
      EXPECT_GT(refined, 1.1 * published) << object.id;
    }
  }
}

}  // namespace
}  // namespace pickbed
