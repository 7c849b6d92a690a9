#include "scenes/base/isolated_call.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(IsolatedCall, ReturnsTheBytesOfTheWork) {
  const std::string large(3000000, 'x');
  EXPECT_EQ(CallIsolated([&] { return large + '\0' + "end"; }), large + '\0' + "end");
  EXPECT_EQ(CallIsolated([] { return std::string(); }), "");
}

TEST(IsolatedCall, KeepsChangesInTheChild) {
  int value = 1;
  CallIsolated([&] {
    value = 2;
    return std::string();
  });
  EXPECT_EQ(value, 1);
}

TEST(IsolatedCall, PassesOnInputErrors) {
  const auto work = []() -> std::string { throw InputError("mesh 'a.obj' has no faces"); };
  EXPECT_EQ(ErrorOf([&] { CallIsolated(work); }), "mesh 'a.obj' has no faces");
  EXPECT_THAT(ErrorOf([] { CallIsolated([]() -> std::string { throw std::logic_error("why"); }); }),
              HasSubstr("why"));
}

TEST(IsolatedCall, SurvivesACrash) {
  EXPECT_THAT(ErrorOf([] { CallIsolated([]() -> std::string { std::abort(); }); }),
              HasSubstr("the process crashed (Aborted)"));
  EXPECT_THAT(ErrorOf([] { CallIsolated([]() -> std::string { _exit(0); }); }),
              HasSubstr("without an answer"));
}

TEST(IsolatedCall, EndsWorkThatTakesTooLong) {
  IsolationLimits limits;
  limits.seconds = 1;
  const auto endless = []() -> std::string {
    while (true) usleep(1000);
  };
  EXPECT_THAT(ErrorOf([&] { CallIsolated(endless, limits); }), HasSubstr("more than 1 s"));
}

TEST(IsolatedCall, LimitsTheResult) {
  IsolationLimits limits;
  limits.result_bytes = 1000;
  const auto large = [] { return std::string(5000, 'x'); };
  EXPECT_THROW(CallIsolated(large, limits), IsolationError);
}

TEST(IsolatedCall, LimitsMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer maps more address space than any limit";
#endif
  IsolationLimits limits;
  limits.memory_bytes = 50000000;
  const auto greedy = []() -> std::string {
    std::vector<std::string> kept;
    while (true) kept.emplace_back(10000000, 'x');
  };
  EXPECT_THAT(ErrorOf([&] { CallIsolated(greedy, limits); }),
              HasSubstr("more than 0.1 GB of memory"));
}

TEST(IsolatedCall, SilencesTheWork) {
  testing::internal::CaptureStderr();
  CallIsolated([] {
    std::fputs("Assertion failed\n", stderr);
    std::fflush(stderr);
    return std::string();
  });
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace pickbed::tests
