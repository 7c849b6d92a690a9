#include "eval/estimate/image_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

TEST(ImagePoses, JsonAndCsvHaveTheSamePoses) {
  auto object = std::make_shared<ObjectModel>();
  object->name = "box";
  PoseHypothesis pose;
  pose.score = 0.75;
  pose.X_CO =
      MakePose(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
               Eigen::Vector3d(0.1, -0.2, 0.8));
  const std::vector<PoseHypothesis> poses{pose};
  const auto json = nlohmann::json::parse(ImagePosesJson({"a.png",
                                                          "d.png",
                                                          {8, 6, 12, 13, 3, 2},
                                                          0.1,
                                                          "ppf:fast",
                                                          "auto",
                                                          {"doubt"},
                                                          0.6,
                                                          "m.net",
                                                          "none",
                                                          7},
                                                         poses, {object}));
  EXPECT_EQ(json["min_score"], 0.6);
  EXPECT_EQ(json["model"], "m.net");
  EXPECT_EQ(json["refiner"], "none");
  EXPECT_EQ(json["seed"], 7);
  EXPECT_EQ(json["camera"]["fy"], 13);
  EXPECT_EQ(json["warnings"][0], "doubt");
  ASSERT_EQ(json["poses"].size(), 1u);
  EXPECT_EQ(json["poses"][0]["object"], "box");
  EXPECT_EQ(json["poses"][0]["R"][0][1], pose.X_CO(0, 1));
  EXPECT_EQ(json["poses"][0]["t_m"][2], 0.8);

  const std::string csv = ImagePosesCsv(poses, {object});
  EXPECT_TRUE(csv.starts_with(
      "object,score,r11,r12,r13,r21,r22,r23,r31,r32,r33,tx_m,ty_m,tz_m\nbox,0.75,"));
  std::vector<double> values;
  std::istringstream line(csv.substr(csv.find("0.75,") + 5));
  for (std::string cell; std::getline(line, cell, ',');) values.push_back(std::stod(cell));
  ASSERT_EQ(values.size(), 12u);
  EXPECT_NEAR(values[3], pose.X_CO(1, 0), 1e-8);
  EXPECT_EQ(values[9], 0.1);
}

TEST(ImagePoses, TableOfKeysNamesEveryKey) {
  const auto json = nlohmann::json::parse(ImagePosesJson({}, {}, {}));
  for (const auto& [key, value] : json.items()) {
    const bool known = std::ranges::any_of(ImagePosesKeys(), [&](const ResultColumn& column) {
      return column.name == key || column.name.starts_with(key + ".") ||
             column.name.starts_with(key + "[");
    });
    EXPECT_TRUE(known) << key;
  }
  EXPECT_EQ(ImagePosesColumns().size(), 14u);
}

}  // namespace
}  // namespace pickbed::tests
