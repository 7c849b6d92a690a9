#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <algorithm>
#include <string_view>

#include "perception/crop_methods/crop_lookup.h"
#include "perception/crop_methods/crop_method.h"
#include "perception/model/pose_distance.h"
#include "perception/networks/wohlhart.h"
#include "perception/training/wohlhart_training.h"
#include "scenes/base/error.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(WohlhartNetwork, NumberOfWeightsEqualsThePaper) {
  WohlhartOptions options;
  options.descriptor = 16;
  EXPECT_EQ(WohlhartNetwork(options, 0).weights(), 269335);
}

// Two crops that differ only in the depth and color of a block far in front of the object.
class DepthReach : public testing::Test {
 protected:
  DepthReach() {
    crops_.spots.resize(2);
    crops_.depth.resize(2 * kCropArea);
    crops_.color.resize(2 * kCropArea);
    for (int i = 0; i < kCropArea; ++i) {
      const auto inside = static_cast<int16_t>(i % 50 * 200);
      crops_.depth[i] = crops_.depth[kCropArea + i] = inside;
      crops_.color[i] = crops_.color[kCropArea + i] = {uint8_t(i % 200), 90, 40};
      if (i % kCropPixels > 20) continue;
      crops_.depth[i] = static_cast<int16_t>(-0.6 * kCropDepthUnit);
      crops_.depth[kCropArea + i] = static_cast<int16_t>(-0.9 * kCropDepthUnit);
      crops_.color[i] = {250, 250, 0};
    }
  }

  bool AreEqual(const char* input, double depth_reach) const {
    WohlhartOptions options;
    options.input = input;
    options.depth_reach = depth_reach;
    const WohlhartNetwork network(options, 3);
    const std::vector<float> rows = network.Describe(crops_);
    return std::equal(rows.begin(), rows.begin() + network.length(),
                      rows.begin() + network.length());
  }

  CropSet crops_;
};

TEST_F(DepthReach, DepthBeyondTheReachIsIgnored) {
  EXPECT_TRUE(AreEqual("depth", 0.5));
  EXPECT_TRUE(AreEqual("rgbd", 0.5));
}

TEST_F(DepthReach, DepthWithinTheReachMatters) {
  EXPECT_FALSE(AreEqual("depth", 1));
  EXPECT_FALSE(AreEqual("rgbd", 0.8));
}

TEST_F(DepthReach, ColorInputIgnoresTheReach) { EXPECT_FALSE(AreEqual("rgb", 0.5)); }

// One anchor at 0 and four templates: the closest one at 1, another pose at 3, another object at 2,
// and a nearly equal pose at 0.5, which is no pusher.
class WohlhartLossValue : public testing::Test {
 protected:
  double Value(const WohlhartOptions& options) const {
    const at::Tensor anchors = torch::zeros({1, 1});
    const at::Tensor templates = torch::tensor({{1.0f}, {3.0f}, {2.0f}, {0.5f}});
    const at::Tensor pose_distance =
        torch::tensor({{0.1f, 0.8f, static_cast<float>(kOtherObject), 0.12f}});
    return WohlhartLoss(anchors, templates, torch::zeros({1}, torch::kLong), pose_distance, options)
        .item<double>();
  }
};

TEST_F(WohlhartLossValue, EqualsTheReleasedCode) {
  WohlhartOptions options;
  options.margin = 1.5;
  options.pair_weight = 2;
  // Hinges 1 - 3 / 2.5 < 0 and 1 - 2 / 2.5 = 0.2, mean over four templates; pair |f_i - f_j| = 1.
  EXPECT_NEAR(Value(options), 0.2 / 4 + 2 * 1, 1e-5);
  options.pushers = 1;
  EXPECT_NEAR(Value(options), 0.2 + 2 * 1, 1e-5);
}

TEST_F(WohlhartLossValue, EqualsHandComputedDynamicMargin) {
  WohlhartOptions options;
  options.dynamic_margin = true;
  options.class_margin = 5;
  options.pair_weight = 0;
  // Squared distances: 1 - 9 / (1 + 0.8) < 0 and 1 - 4 / (1 + 5).
  EXPECT_NEAR(Value(options), (1 - 4.0 / 6) / 4, 1e-5);
}

TEST(WohlhartOptions, OutOfRangeSettingsReportTheRange) {
  WohlhartOptions options;
  const auto set = [&](const std::string& text) {
    return ErrorOf([&] { ApplySetting(text, [&](SettingsVisitor& v) { options.Visit(v); }); });
  };
  EXPECT_THAT(set("descriptor=1"), HasSubstr("1024"));
  EXPECT_THAT(set("margin=-1"), HasSubstr("10"));
  EXPECT_THAT(set("input=grey"), HasSubstr("depth, rgb, rgbd"));
  EXPECT_THAT(set("depth_reach=0"), HasSubstr("0.1"));
}

// Two objects seen from few directions. Seconds of training are enough to learn something.
class WohlhartTraining : public testing::Test {
 protected:
  WohlhartTraining() {
    views_.template_level = 1;
    views_.train_level = 2;
    RayCastViews clean({ObjectOf(BracketMesh()), ObjectOf(BoxMesh({0.05, 0.04, 0.06}, {0, 0, 0}))},
                       0);
    RayCastViews noisy(clean.objects(), 0.0005);
    training_set_ = std::make_shared<CropTrainingSet>(MakeCropTrainingSet(clean, noisy, views_, 1));
    options_.input = "depth";
    options_.descriptor = 8;
    options_.iterations = 12;
    options_.mine_every = 8;
    options_.anchors = 12;
  }

  // Returns the number of new views whose nearest template is of the right object.
  int CountRightObjects(const WohlhartNetwork& network) {
    const auto method = MakeCropLookup(
        training_set_,
        [&](const CropSet& crops, int threads) { return network.Describe(crops, threads); },
        network.length(), 1);
    RayCastViews source(training_set_->objects, 0);
    int right = 0;
    for (ObjectId object{0}; object < 2; ++object) {
      Rng rng(9);
      const ObjectCrops tests =
          RenderCrops(source, object, TestRotations(20, views_, rng), views_, 5);
      for (const auto& answers : method->Answer(tests.crops, 1, 1)) {
        right += answers.front().object == object;
      }
    }
    return right;
  }

  CropViewOptions views_;
  std::shared_ptr<CropTrainingSet> training_set_;
  WohlhartOptions options_;
  const TemporaryFolder folder_;
};

TEST_F(WohlhartTraining, LearnsToDistinguishObjects) {
  options_.iterations = 30;
  const auto network = TrainWohlhart({*training_set_, 1, {}, {}}, options_);
  EXPECT_GE(CountRightObjects(*network), 38);
}

TEST_F(WohlhartTraining, SameDescriptorsAfterResumeAndOnTwoThreads) {
  const auto straight = TrainWohlhart({*training_set_, 1, {}, {}}, options_);
  int steps = 0;
  WohlhartJob job{*training_set_, 1, folder_.path() / "net.checkpoint", {}};
  job.on_progress = [&](double, double) { return ++steps < 13; };
  EXPECT_EQ(TrainWohlhart(job, options_), nullptr);
  job.on_progress = {};
  job.threads = 2;
  const auto resumed = TrainWohlhart(job, options_);
  const CropSet& crops = training_set_->templates[0].crops;
  EXPECT_EQ(straight->Describe(crops), resumed->Describe(crops, 2));
  const auto is_refused = [&] {
    EXPECT_THAT(ErrorOf([&] { TrainWohlhart(job, options_); }),
                HasSubstr("other settings or objects"));
  };
  job.seed = 2;
  is_refused();
  job.seed = 1;
  training_set_->training[1].crops.color.front().g ^= 1;
  is_refused();
}

TEST_F(WohlhartTraining, ObjectWithoutTrainingViewsIsRefused) {
  training_set_->training[1] = {};
  EXPECT_THAT(ErrorOf([&] {
                TrainWohlhart({*training_set_, 1, {}, {}}, options_);
              }),
              HasSubstr("raise train_level above template_level"));
}

// Every method finds a template as its own nearest neighbour.
class CropMethods : public testing::TestWithParam<const char*> {};

TEST_P(CropMethods, TemplateIsItsOwnNearestNeighbor) {
  CropViewOptions views;
  views.template_level = 1;
  views.train_level = 2;
  RayCastViews source({ObjectOf(BracketMesh()), ObjectOf(BoxMesh({0.05, 0.04, 0.06}, {0, 0, 0}))},
                      0);
  const auto training_set =
      std::make_shared<CropTrainingSet>(MakeCropTrainingSet(source, source, views, 1));
  const auto rows = CropMethodTable();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const CropMethodRow& r) {
    return r.name == std::string_view(GetParam());
  });
  ASSERT_NE(row, rows.end());
  CropMethodSetup setup{training_set, {}, {}, 1, {}};
  setup.options.wohlhart.iterations = 1;
  setup.options.wohlhart.anchors = 4;
  const auto method = row->make(setup);
  const ObjectCrops& object_templates = training_set->templates[0];
  const RotationDistance distance(training_set->objects[0]->symmetries_O);
  const auto answers = method->Answer(object_templates.crops, 3, 1);
  EXPECT_EQ(answers, method->Answer(object_templates.crops, 3, 2));
  int found = 0;
  for (size_t i = 0; i < answers.size(); ++i) {
    ASSERT_LE(answers[i].size(), 3u);
    for (size_t n = 1; n < answers[i].size(); ++n) {
      EXPECT_LE(answers[i][n - 1].distance, answers[i][n].distance);
    }
    found += !answers[i].empty() && answers[i][0].object == 0 &&
             distance(answers[i][0].R_CO, object_templates.R_CO[i]) < 1e-6;
  }
  EXPECT_GE(found, 0.9 * static_cast<double>(answers.size()));
}

INSTANTIATE_TEST_SUITE_P(Rows, CropMethods,
                         testing::Values("wohlhart", "wohlhart_16", "wohlhart_depth", "hog"));

}  // namespace
}  // namespace pickbed::tests
