#include "sim/render/gl_context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <thread>

#include "sim/render/renderer.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

std::unique_ptr<GlContext> MakeOrNull(GlBackend backend) {
  try {
    return MakeGlContext({backend, 0});
  } catch (const std::runtime_error&) {
    return nullptr;
  }
}

class GlContextBackend : public testing::TestWithParam<GlBackend> {};

TEST_P(GlContextBackend, ProvidesOpenGl33AndItsName) {
  const auto context = MakeOrNull(GetParam());
  if (!context) GTEST_SKIP() << "this kind of context cannot be made here";
  using GetIntegerv = void (*)(unsigned, int*);
  const auto get = reinterpret_cast<GetIntegerv>(context->GetProcAddress("glGetIntegerv"));
  ASSERT_NE(get, nullptr);
  constexpr unsigned kMajorVersion = 0x821B, kMinorVersion = 0x821C;
  int major = 0, minor = 0;
  get(kMajorVersion, &major);
  get(kMinorVersion, &minor);
  EXPECT_GE(10 * major + minor, 33);
  EXPECT_THAT(context->Name(),
              testing::StartsWith(GetParam() == GlBackend::kEgl ? "EGL, " : "OSMesa, "));
}

INSTANTIATE_TEST_SUITE_P(Both, GlContextBackend,
                         testing::Values(GlBackend::kOsMesa, GlBackend::kEgl),
                         [](const auto& info) {
                           return info.param == GlBackend::kEgl ? "Egl" : "OsMesa";
                         });

// Runs in a separate process whose EGL finds no driver.
TEST(GlContextDeathTest, MissingDriverErrorListsThePackages) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto make_without_driver = [] {
    setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere.json", 1);
    try {
      MakeGlContext({GlBackend::kEgl, 0});
      std::cerr << "made one";
    } catch (const std::runtime_error& error) {
      std::cerr << error.what();
    }
    std::exit(0);
  };
  EXPECT_EXIT(make_without_driver(), testing::ExitedWithCode(0),
              "install the packages: libegl1 libegl-mesa0 libgl1-mesa-dri");
}

TEST(GlContext, AutoFindsABackend) {
  const auto context = MakeGlContext();
  EXPECT_FALSE(context->Name().empty());
}

TEST(GlContext, RasterThreadCountIsGivenToTheDriver) {
  MakeGlContext({GlBackend::kAuto, 3});
  EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "3");
  MakeGlContext();
  EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "0");
}

// Renderers of both backends draw alternately and are destroyed in between. Each must keep its own
// state.
TEST(GlContext, SeveralContextsWorkInOneProcess) {
  std::vector<GlBackend> kinds = {GlBackend::kAuto, GlBackend::kAuto, GlBackend::kAuto};
  if (MakeOrNull(GlBackend::kEgl) && MakeOrNull(GlBackend::kOsMesa)) {
    kinds = {GlBackend::kOsMesa, GlBackend::kEgl, GlBackend::kOsMesa, GlBackend::kEgl};
  }
  struct Entry {
    std::unique_ptr<Renderer> renderer;
    int mesh;
    RenderedImage first;
  };
  std::vector<Entry> entries;
  const Camera camera = TestCamera(50, 40, 60);
  const auto draw = [&](Entry& entry) {
    return entry.renderer->Render(
        camera, std::vector{RenderInstance{entry.mesh, Translation({0, 0, 0.5}), 1}});
  };
  for (size_t i = 0; i < kinds.size(); ++i) {
    GlContextOptions options;
    options.backend = kinds[i];
    Entry entry{std::make_unique<Renderer>(options), 0, {}};
    entry.mesh = entry.renderer->AddMesh(BoxMesh(Eigen::Vector3d(0.1, 0.02 * (i + 1), 0.1)));
    entry.first = draw(entry);
    entries.push_back(std::move(entry));
  }
  EXPECT_NE(entries[0].first.ids, entries[1].first.ids);
  for (int round = 0; round < 3; ++round) {
    for (Entry& entry : entries) EXPECT_EQ(draw(entry).depth_m, entry.first.depth_m);
    if (entries.size() > 2) entries.erase(entries.begin() + round % 2);
  }
}

TEST(GlContext, MovesBetweenThreads) {
  std::unique_ptr<Renderer> renderer;
  int mesh = 0;
  RenderedImage images[2];
  for (RenderedImage& image : images) {
    std::thread([&] {
      if (!renderer) {
        renderer = std::make_unique<Renderer>();
        mesh = renderer->AddMesh(BoxMesh({0.1, 0.1, 0.1}));
      }
      image = renderer->Render(TestCamera(30, 30, 40),
                               std::vector{RenderInstance{mesh, Translation({0.02, 0, 0.5}), 1}});
    }).join();
  }
  EXPECT_EQ(images[0].depth_m, images[1].depth_m);
  EXPECT_GT(images[0].depth_m(16, 15), 0.4);
}

}  // namespace
}  // namespace pickbed::tests
