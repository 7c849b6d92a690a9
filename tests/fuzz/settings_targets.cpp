#include "eval/grasps/gripper_frame.h"
#include "eval/sweep/sweep_spec.h"
#include "grasp/grippers/table.h"
#include "scenes/scenario/find_scenario.h"
#include "scenes/scenario/scenario_spec.h"
#include "sim/sensor/sensor_profile.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

Contents FilesOf(const fs::path& folder) {
  Contents contents;
  for (const std::string& stem : StemsIn(folder, ".yaml")) {
    contents.push_back(ReadFileBytes(folder / (stem + ".yaml")));
  }
  return contents;
}

std::function<Contents()> Assets(const char* folder) {
  return [folder] { return FilesOf(AssetsDir() / folder); };
}

Contents Scenarios() {
  Contents contents = FilesOf(PresetsDir());
  std::erase_if(contents, [](const std::string& text) {
    return text.find("\ngrid:") != std::string::npos;  // a sweep
  });
  return contents;
}

constexpr const char* kSweep =
    "scenario: demo\ntrials: 3\nset: {camera.focal_px: 700}\ngrid:\n  sensor: [ideal, "
    "time_of_flight]\n  seed: 1..3\n  fill: {half: {objects.0.count: 4}, full: "
    "{objects.0.count: 9}}\nslurm: {shards: 4, partition: short, time: 2:00:00}\n";
constexpr const char* kHandFrame = "approach: -x\nclosing: y\ntip_m: [0.1, 0, -0.002]\n";

}  // namespace

std::vector<FuzzTarget> SettingsTargets() {
  return {
      OneFile(
          "scenario", "a.yaml", [](const fs::path& file) { LoadScenario(file); }, Scenarios),
      OneFile(
          "sweep", "a.yaml",
          [](const fs::path& file) {
            MakeSweep(LoadSweepSpec(file), file.parent_path() / "out", "");
          },
          [] { return Contents{kSweep}; }),
      OneFile(
          "gripper", "a.yaml", [](const fs::path& file) { LoadGripper(file.string()); },
          Assets("grippers")),
      OneFile(
          "gripper_frame", "a.yaml",
          [](const fs::path& file) {
            const Pose X_FG = LoadGripperFrame(file.string()).X_FG();
            RequireLaw(X_FG.matrix().allFinite() && X_FG.linear().isUnitary(1e-9),
                       "the frame of a hand is a pose");
          },
          [] { return Contents{kHandFrame}; }),
      OneFile(
          "sensor", "a.yaml", [](const fs::path& file) { LoadSensorProfile(file.string()); },
          Assets("sensors")),
      OneFile(
          "bin", "a.yaml", [](const fs::path& file) { LoadBin(file.string()); }, Assets("bins")),
  };
}

}  // namespace pickbed::tests
