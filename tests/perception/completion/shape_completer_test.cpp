#include "perception/completion/shape_completer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "perception/completion/completion_input.h"
#include "perception/completion/nearest_shape.h"
#include "perception/completion/network_completer.h"
#include "perception/completion/rule_completers.h"
#include "perception/completion/training_sample.h"
#include "scenes/base/error.h"
#include "tests/perception/completion/solid_views.h"

namespace pickbed::perception {
namespace {

using ::testing::HasSubstr;

// Returns the IoU of a volume and a body, which is given by what is inside of it.
double Iou(const CompletedVolume& volume,
           const std::function<bool(const Eigen::Vector3f& p_C)>& is_inside) {
  double both = 0, either = 0;
  for (int z = 0; z < volume.size; ++z) {
    for (int y = 0; y < volume.size; ++y) {
      for (int x = 0; x < volume.size; ++x) {
        const bool full = volume.occupancy[volume.Index(x, y, z)] > 0.5f;
        const bool inside = is_inside(volume.Center_C(x, y, z));
        both += full && inside;
        either += full || inside;
      }
    }
  }
  return both / either;
}

double SphereIou(const CompletedVolume& volume) {
  return Iou(volume, [](const Eigen::Vector3f& p_C) {
    return (p_C.cast<double>() - kSphereCenter_C).norm() < kSphereRadius_m;
  });
}

CompletedVolume Completed(CompletionRule rule, const SegmentView& view) {
  CompletionOptions options;
  options.cells = 48;
  return MakeRuleCompleter(rule, options)->Complete(view);
}

TEST(RuleCompleters, OverlapsWithASphereFollowFromGeometry) {
  const SegmentView view = UsualSphereView();
  // The mirror image of a sphere at its outline is the sphere. A prism of the same height fills
  // 2/3 of the volume between its front and its back; the shares follow by integration.
  EXPECT_GT(SphereIou(Completed(CompletionRule::kMirror, view)), 0.85);
  EXPECT_GT(SphereIou(Completed(CompletionRule::kLocalThickness, view)), 0.6);
  EXPECT_GT(SphereIou(Completed(CompletionRule::kExtrusion, view)), 0.7);
  EXPECT_LT(SphereIou(Completed(CompletionRule::kSkirt, view)), 0.45);
}

TEST(RuleCompleters, TheSkirtIsAsDeepAsStated) {
  const CompletedVolume volume = Completed(CompletionRule::kSkirt, UsualSphereView());
  const Eigen::Vector3f front_C =
      (kSphereCenter_C * (1 - kSphereRadius_m / kSphereCenter_C.norm())).cast<float>();
  const Eigen::Vector3f ray_C = front_C.normalized();
  EXPECT_GT(volume.At(front_C + 0.012f * ray_C), 0.5);
  EXPECT_LT(volume.At(front_C + 0.019f * ray_C), 0.5);
}

TEST(RuleCompleters, NothingIsBelowTheFloor) {
  SegmentView view = UsualSphereView();
  FloorPlane floor;
  floor.offset_m = -0.6f;
  view.floor = floor;
  const CompletedVolume volume = Completed(CompletionRule::kMirror, view);
  EXPECT_EQ(volume.At({0.03f, -0.02f, 0.62f}), 0);
  EXPECT_EQ(volume.At({0.03f, -0.02f, 0.58f}), 1);
}

TEST(NearestShape, CompletesASphereByCartonsAndCans) {
  NearestShape nearest({&FindShapeFamily("carton"), &FindShapeFamily("can")}, 40, 32);
  EXPECT_GT(SphereIou(nearest.Complete(UsualSphereView())), 0.3);
}

// Returns the mean IoU of views of other cans that are completed by training views of one family.
double MeanIouOfCans(const char* family) {
  NearestShape nearest({&FindShapeFamily(family)}, 80, 32);
  RandomViewOptions whole;
  whole.occluded_share = 0;
  Rng rng(5);
  double sum = 0;
  constexpr int kViews = 8;
  for (int i = 0; i < kViews; ++i) {
    const auto can =
        SolidOf(SampleShape(FindShapeFamily("can"), ShapeSplit::kUnseenSizes, rng.Next()).solid);
    const RandomView drawn = DrawView(*can, {}, whole, rng);
    const Eigen::Isometry3f X_OC = drawn.X_CO.inverse().cast<float>();
    sum += Iou(nearest.Complete(drawn.view), [&](const Eigen::Vector3f& p_C) {
      const Eigen::Vector3f p_O = X_OC * p_C;
      uint8_t inside = 0;
      can->Inside({&p_O, 1}, {&inside, 1});
      return inside != 0;
    });
  }
  return sum / kViews;
}

TEST(NearestShape, TakesTheShapeOfItsTrainingViews) {
  const double by_cans = MeanIouOfCans("can"), by_plates = MeanIouOfCans("plate");
  EXPECT_GT(by_cans, 0.5);
  EXPECT_LT(by_plates, 0.5 * by_cans);
}

TEST(NetworkCompleter, EmptyCellsAreZeroAndOthersAreProbabilities) {
  CompletionNetworkOptions options;
  options.width_16 = options.width_8 = options.width_4 = options.bottleneck = 4;
  const CompletionNetwork network(options, 1);
  const SegmentView view = UsualSphereView();
  const CompletedVolume volume = CompleteWithNetwork(network, view, 24);
  const CompletionInput input(view);
  int asked = 0;
  for (int z = 0; z < 24; ++z) {
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 24; ++x) {
        const float p = volume.occupancy[volume.Index(x, y, z)];
        const bool empty = input.IsKnownEmpty(volume.Center_C(x, y, z));
        EXPECT_EQ(p == 0, empty);
        asked += !empty;
      }
    }
  }
  EXPECT_GT(asked, 500);
}

TEST(NetworkCompleter, DoesNotDependOnWhatIsBehind) {
  CompletionNetworkOptions options;
  options.width_16 = options.width_8 = options.width_4 = options.bottleneck = 4;
  const CompletionNetwork network(options, 1);
  EXPECT_EQ(CompleteWithNetwork(network, UsualSphereView(0.75f), 16).occupancy,
            CompleteWithNetwork(network, UsualSphereView(2.5f), 16).occupancy);
}

TEST(ShapeCompleter, RefusesUnknownMethodsAndMissingModels) {
  CompletionOptions options;
  options.method = "skrit";
  try {
    MakeCompleter(options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'skirt'"));
  }
  options.method = "network";
  options.model = "no/such/model.net";
  EXPECT_THROW(MakeCompleter(options), InputError);
}

}  // namespace
}  // namespace pickbed::perception
