#include "eval/runtime/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

ProgressState SomeTrials() {
  ProgressState state;
  state.done = 30;
  state.total = 40;
  state.done_before = 20;
  state.counts_successes = true;
  for (int i = 0; i < 10; ++i) state.outcomes.push_back({i % 2 == 0 ? 3 : 1, 3});
  return state;
}

TEST(Progress, TextHasRateTimeLeftAndSuccessInterval) {
  const std::string text = ProgressText(SomeTrials(), 20.0);
  EXPECT_THAT(text, HasSubstr("trial 30/40  0.50 trials/s  left 0:20"));
  EXPECT_THAT(text, HasSubstr("picked 20/30 = 66.7 % ["));
}

TEST(Progress, JsonHasTheSameNumbers) {
  const auto json = nlohmann::json::parse(ProgressJson(SomeTrials(), 20.0));
  EXPECT_EQ(json["done"], 30);
  EXPECT_EQ(json["total"], 40);
  EXPECT_EQ(json["per_s"], 0.5);
  EXPECT_EQ(json["left_s"], 20.0);
  EXPECT_EQ(json["executed_grasps"], 30);
  EXPECT_EQ(json["successes"], 20);
  EXPECT_LT(json["success_ci95"][0], json["success_rate"]);
  EXPECT_GT(json["success_ci95"][1], json["success_rate"]);
}

// The standard error output of a test is no terminal here.
TEST(Progress, FilesGetALineOnlyWhenTheNumberChanges) {
  ProgressState state;
  state.what = "view";
  state.total = 40;
  testing::internal::CaptureStderr();
  ProgressLine progress;
  for (int i = 0; i < 2; ++i) {
    state.note = std::to_string(i);
    progress.Show(state);
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
  }
  state.done = 1;
  progress.Show(state);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, HasSubstr("view 0/40"));
  EXPECT_THAT(text, HasSubstr("view 1/40"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
}

TEST(Progress, TimeLeftIncludesLaterWork) {
  ProgressState state = SomeTrials();
  state.later_s = 100;
  EXPECT_THAT(ProgressText(state, 20.0), HasSubstr("left 2:00"));
  EXPECT_EQ(nlohmann::json::parse(ProgressJson(state, 20.0))["left_s"], 120.0);
}

TEST(Progress, TimeLeftIsUnknownAtTheStart) {
  ProgressState state;
  state.total = 40;
  EXPECT_THAT(ProgressText(state, 3.0), HasSubstr("left ?"));
  EXPECT_THAT(ProgressText(state, 3.0), Not(HasSubstr("picked")));
  EXPECT_TRUE(nlohmann::json::parse(ProgressJson(state, 3.0))["left_s"].is_null());
}

}  // namespace
}  // namespace pickbed::tests
