#include <set>

#include "eval/bop/check_dataset.h"
#include "eval/bop/dataset_card.h"
#include "eval/bop/dataset_scores.h"
#include "eval/bop/layout.h"
#include "eval/bop/results_csv.h"
#include "eval/bop/stored_scenes.h"
#include "eval/cell/simulated_cell.h"
#include "scenes/base/error.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

// A dataset with one file replaced.
class SmallDataset {
 public:
  SmallDataset() { MakeSmall(temporary_.path(), 1, 2); }
  std::string Read(const std::string& file) const {
    return ReadFileBytes(temporary_.path() / file);
  }
  void CopyTo(const fs::path& folder) const {
    fs::copy(temporary_.path(), folder, fs::copy_options::recursive);
  }

 private:
  const TemporaryFolder temporary_;
};

const SmallDataset& Small() {
  static const SmallDataset dataset;
  return dataset;
}

FuzzTarget BopTarget(const std::string& name, const std::string& file, int replays = 40) {
  const auto run = [file](const fs::path& folder, const std::string& bytes) {
    const fs::path root = folder / "set";
    fs::remove_all(root);
    Small().CopyTo(root);
    WriteFileAtomically(root / file, bytes);
    const std::vector<std::string> faults = CheckDataset(root).faults;
    EvaluateDataset(root, "test", {});
    if (!faults.empty()) throw InputError(faults.front());
  };
  FuzzTarget target{"bop_" + name, run, [file] { return Contents{Small().Read(file)}; }};
  target.reads_file = false;  // other files of the set can be at fault
  target.replays = replays;
  return target;
}

FuzzTarget CardTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    const fs::path root = folder / "set";
    if (!fs::exists(root)) Small().CopyTo(root);
    WriteFileAtomically(root / kCardFile, bytes);
    for (const auto& [id, object] : ObjectsOfCard(root)) {
      RequireLaw(id >= 1 && !object.name.empty(), "an object has a number and a name");
    }
  };
  return {"dataset_card", run, [] { return Contents{Small().Read(kCardFile)}; }};
}

// The bin, as the scenes of the dataset have it.
const Bin& SmallBin() {
  static const SimulatedCell cell(SmallScenario(), EasyCube());
  return cell.bin();
}

void RequireScenes(const StoredScenes& stored) {
  for (const Scene& scene : stored.scenes) {
    std::set<InstanceId> instances;
    for (const PosedObject& posed : scene.objects) {
      RequireLaw(posed.X_WO.matrix().allFinite() && posed.X_WO.linear().isUnitary(1e-6),
                 "an instance has a pose");
      RequireLaw(posed.X_WO.translation().norm() < 100, "an instance is near the bin");
      RequireLaw(posed.deviation.friction > -1 && posed.deviation.mass > -1,
                 "friction and mass stay positive");
      RequireLaw(instances.insert(posed.instance).second, "each instance is there once");
    }
  }
  for (const double size : stored.sizes) RequireLaw(size > -1, "an object has a size");
}

FuzzTarget StoredScenesTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / kStoredScenesFile, bytes);
    RequireScenes(ReadStoredScenes(folder, SmallBin(), EasyCube()));
  };
  const auto seeds = [] {
    return Contents{Small().Read(std::string("test/000001/") + kStoredScenesFile)};
  };
  return {"stored_scenes", run, seeds};
}

constexpr const char* kResults =
    "scene_id,im_id,obj_id,score,R,t,time\n1,1,1,0.9,1 0 0 0 1 0 0 0 1,10 20 500,0.1\n1,2,1,0.5,0 "
    "-1 0 1 0 0 0 0 1,-10.5 0 612.25,-1\n";

}  // namespace

std::vector<FuzzTarget> DatasetTargets() {
  return {
      BopTarget("camera", "test/000001/scene_camera.json"),
      BopTarget("truth", "test/000001/scene_gt.json"),
      BopTarget("truth_info", "test/000001/scene_gt_info.json"),
      BopTarget("models_info", "models/models_info.json"),
      BopTarget("targets", "test_targets_bop19.json"),
      BopTarget("model", "models/obj_000001.ply"),
      BopTarget("depth", "test/000001/depth/000001.png"),
      BopTarget("dataset_camera", "camera.json", 8),
      BopTarget("mask", "test/000001/mask/000001_000000.png", 8),
      CardTarget(),
      StoredScenesTarget(),
      OneFile(
          "results_csv", "a.csv", [](const fs::path& file) { ReadEstimates(file); },
          [] { return Contents{kResults}; }),
  };
}

}  // namespace pickbed::tests
