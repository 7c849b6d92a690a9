#include "sim/drop/certified_scene.h"

#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

SceneCertificate ValidCertificate() {
  SceneCertificate certificate;
  certificate.at_rest = true;
  return certificate;
}

TEST(SceneCertificate, EachFaultHasItsMessage) {
  EXPECT_TRUE(Faults(ValidCertificate()).empty());
  const auto only_fault = [](const SceneCertificate& certificate) {
    const auto faults = Faults(certificate);
    return faults.size() == 1 ? faults[0] : std::to_string(faults.size()) + " faults";
  };
  SceneCertificate certificate = ValidCertificate();
  certificate.at_rest = false;
  certificate.simulated_s = 8.5;
  EXPECT_EQ(only_fault(certificate), "not at rest after 8.5 s");
  certificate = ValidCertificate();
  certificate.instances_outside = 1;
  EXPECT_EQ(only_fault(certificate), "1 instance fell outside the bin");
  certificate = ValidCertificate();
  certificate.deepest_penetration_m = 0.0006;
  EXPECT_EQ(only_fault(certificate), "two bodies overlap by 0.60 mm");
  certificate.deepest_penetration_m = 0.0004;
  EXPECT_TRUE(Faults(certificate).empty());
  certificate.blew_up = true;
  EXPECT_NE(only_fault(certificate).find("physics failed"), std::string::npos);
}

TEST(MakeScene, SceneIsValidAndRepeats) {
  const ObjectSet objects = MixedObjects();
  const SceneRequest request{Bin{}, objects, {4, 4, 4, 4}, 5, BinIndex(2)};
  const CertifiedScene first = MakeScene(request), second = MakeScene(request);
  EXPECT_TRUE(Faults(first.certificate).empty());
  EXPECT_LT(first.certificate.wake_movement_diameters, DropOptions().wake_diameters);
  EXPECT_LT(first.certificate.max_speed_mps, 0.02);
  ASSERT_EQ(first.scene.objects.size(), 16u);
  for (size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(first.scene.objects[i].X_WO.matrix(), second.scene.objects[i].X_WO.matrix());
  }
}

// Free fall converts potential into kinetic energy, and contacts dissipate it.
TEST(MakeScene, TotalEnergyNeverRises) {
  const ObjectSet objects{BoxObject({0.04, 0.04, 0.04}, 0.2)};
  DropOptions options;
  const auto energy = MakeScene({Bin{}, objects, {1}, 0, BinIndex(0)}, options).certificate.energy;
  ASSERT_GT(energy.size(), 10u);
  double last_j = 1e9;
  for (const EnergySample& sample : energy) {
    EXPECT_GE(sample.kinetic_j, 0);
    const double total_j = sample.kinetic_j + sample.potential_j;
    EXPECT_LT(total_j, last_j + 2e-3);  // a step of free fall has an error of m g v dt / 2
    last_j = total_j;
  }
  EXPECT_NEAR(energy.back().potential_j, 0.2 * 9.81 * 0.02, 0.002);  // it rests on the floor
  EXPECT_LT(energy.back().kinetic_j, 1e-6);
}

// The tray is just large enough for these cubes, so that only some scenes pass.
TEST(MakeScene, RefusedScenesAreListedAndFollowedByANewSeed) {
  Bin tray;
  tray.inner_size_m = {0.12, 0.12, 0.05};
  const ObjectSet cubes{BoxObject({0.03, 0.03, 0.03}, 0.05)};
  int refused = 0;
  for (BinIndex bin_index(0); bin_index < 6; ++bin_index) {
    const CertifiedScene made = MakeScene({tray, cubes, {15}, 0, bin_index}, {}, 50);
    EXPECT_EQ(made.scene.objects.size(), 15u);
    for (const RefusedScene& scene : made.refused) {
      EXPECT_EQ(scene.attempt, static_cast<int>(&scene - made.refused.data()));
      EXPECT_FALSE(scene.faults.empty());
      ++refused;
    }
  }
  EXPECT_GT(refused, 0) << "the case did not occur";
}

TEST(MakeScene, OverfilledBinIsRefusedWithAReason) {
  Bin tray;
  tray.inner_size_m = {0.1, 0.1, 0.02};
  const ObjectSet cubes{BoxObject({0.04, 0.04, 0.04}, 0.1)};
  try {
    MakeScene({tray, cubes, {30}, 0, BinIndex(3)}, {}, 2);
    FAIL() << "no error";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("trial 3: 2 scenes in a row were refused"), std::string::npos);
    EXPECT_NE(message.find("fell outside the bin"), std::string::npos);
    EXPECT_NE(message.find("fewer objects, lower the fill or use a larger bin"), std::string::npos);
  }
}

}  // namespace
}  // namespace pickbed::tests
