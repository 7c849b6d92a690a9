#include "scenes/camera/camera.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using namespace scenes;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

struct CameraFault {
  const char* name;
  int width;
  int height;
  double fx, fy, cx, cy;
};

TEST(CameraIntrinsics, EachFaultIsNamedAlone) {
  const CameraFault faults[] = {
      {"width", 0, 480, 600, 600, 320, 240},
      {"width", CameraIntrinsics::kMaxSize_px + 1, 480, 600, 600, 320, 240},
      {"height", 640, -1, 600, 600, 320, 240},
      {"fx", 640, 480, 0, 600, 320, 240},
      {"fx", 640, 480, kInfinite, 600, 320, 240},
      {"fy", 640, 480, 600, -5, 320, 240},
      {"fy", 640, 480, 600, kNan, 320, 240},
      {"cx", 640, 480, 600, 600, kNan, 240},
      {"cy", 640, 480, 600, 600, 320, -kInfinite},
  };
  for (const CameraFault& f : faults) {
    const std::string error =
        ErrorOf([&] { CameraIntrinsics(f.width, f.height, f.fx, f.fy, f.cx, f.cy); });
    EXPECT_TRUE(error.starts_with(std::string("camera intrinsics: ") + f.name + " = ")) << error;
    EXPECT_EQ(error.find(';'), std::string::npos) << error;
  }
}

TEST(CameraIntrinsics, AllFaultsAreNamedInOneLine) {
  const std::string error = ErrorOf([] { CameraIntrinsics(0, -480, kNan, 0, kInfinite, kNan); });
  EXPECT_EQ(error,
            "camera intrinsics: width = 0: must be from 1 to 65536 px; "
            "height = -480: must be from 1 to 65536 px; "
            "fx = nan: must be from 0.001 to 1e+12 px; "
            "fy = 0: must be from 0.001 to 1e+12 px; "
            "cx = inf: must be from -1e+12 to 1e+12 px; "
            "cy = nan: must be from -1e+12 to 1e+12 px");
  EXPECT_EQ("camera intrinsics: " + CameraIntrinsics::FaultsOf(0, -480, kNan, 0, kInfinite, kNan),
            error);
}

TEST(CameraIntrinsics, ValidValuesAreKept) {
  const CameraIntrinsics k(1, CameraIntrinsics::kMaxSize_px, 0.5, 600, -100, 9000);
  EXPECT_EQ(k.width(), 1);
  EXPECT_EQ(k.height(), CameraIntrinsics::kMaxSize_px);
  EXPECT_EQ(k.fx(), 0.5);
  EXPECT_EQ(k.fy(), 600);
  EXPECT_EQ(k.cx(), -100);
  EXPECT_EQ(k.cy(), 9000);
  EXPECT_EQ(CameraIntrinsics::FaultsOf(1, 1, 0.5, 600, -100, 9000), "");
  static_assert(CameraIntrinsics() == CameraIntrinsics(640, 480, 680, 680, 319.5, 239.5));
}

TEST(CameraIntrinsics, WindowShowsTheSamePointsShifted) {
  const CameraIntrinsics k(640, 480, 600, 610, 320, 240);
  const CameraIntrinsics window = k.Window(-20, 30, 50, 60);
  EXPECT_EQ(window.width(), 50);
  EXPECT_EQ(window.height(), 60);
  const Eigen::Vector3d p_C(0.1, -0.2, 0.9);
  EXPECT_TRUE(Project(window, p_C).isApprox(Project(k, p_C) - Eigen::Vector2d(-20, 30), 1e-12));
  EXPECT_THROW(k.Window(0, 0, 0, 60), InputError);
}

}  // namespace
}  // namespace pickbed::tests
