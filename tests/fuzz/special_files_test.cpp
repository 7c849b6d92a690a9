// Files that are no regular files. A pipe would make its reader wait for ever, and a device has no
// end. Each reader must refuse them at once and name them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "eval/bop/results_csv.h"
#include "eval/frames/frame_files.h"
#include "eval/store/results_store.h"
#include "eval/sweep/sweep_spec.h"
#include "grasp/grippers/table.h"
#include "perception/completion/completion_file.h"
#include "perception/networks/model_file.h"
#include "perception/networks/verifier_file.h"
#include "scenes/bin/bin.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/scenario/scenario_spec.h"
#include "sim/sensor/sensor_profile.h"
#include "tests/fuzz/campaign.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

struct Reader {
  const char* name;
  const char* file;  // its name; its ending matters to some
  std::function<void(const fs::path& file)> read;
};

const std::vector<Reader>& Readers() {
  static const std::vector<Reader> readers{
      {"Scenario", "a.yaml", [](const fs::path& file) { LoadScenario(file); }},
      {"Sweep", "a.yaml", [](const fs::path& file) { LoadSweepSpec(file); }},
      {"Gripper", "a.yaml", [](const fs::path& file) { LoadGripper(file.string()); }},
      {"Sensor", "a.yaml", [](const fs::path& file) { LoadSensorProfile(file.string()); }},
      {"Bin", "a.yaml", [](const fs::path& file) { LoadBin(file.string()); }},
      {"Obj", "a.obj", [](const fs::path& file) { LoadMesh(file); }},
      {"Ply", "a.ply", [](const fs::path& file) { LoadMesh(file); }},
      {"Stl", "a.stl", [](const fs::path& file) { LoadMesh(file); }},
      {"Png", "a.png", [](const fs::path& file) { ReadPng(file); }},
      {"Depth", "a.png", [](const fs::path& file) { ReadPng16(file); }},
      {"ResultsCsv", "a.csv", [](const fs::path& file) { ReadEstimates(file); }},
      {"Store", kStoreFile,
       [](const fs::path& file) { ResultsStore::OpenToRead(file.parent_path()); }},
      {"Model", "a.net", [](const fs::path& file) { LoadModel(file); }},
      {"Verifiers", "a.net", [](const fs::path& file) { LoadVerifiers(file, "ppf"); }},
      {"CompletionModel", "a.net", [](const fs::path& file) { LoadCompletionModel(file); }},
      {"Cloud", "a.pcd",
       [](const fs::path& file) {
         FrameFiles files;
         files.image = file;
         ReadFrameFiles(files);
       }},
  };
  return readers;
}

class SpecialFiles : public testing::TestWithParam<Reader> {
 protected:
  fs::path Place() const {
    const fs::path file = temporary_.path() / GetParam().file;
    fs::create_directories(file.parent_path());
    return file;
  }
  // In a process of its own, which ends if the reader waits.
  FuzzCase ResultOf(const fs::path& file) const {
    const auto read = [&](const fs::path&, const std::string&) { GetParam().read(file); };
    return RunFuzzCase({GetParam().name, read, {}}, temporary_.path(), "");
  }
  const TemporaryFolder temporary_;
};

TEST_P(SpecialFiles, APipeIsRefused) {
  const fs::path file = Place();
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  const FuzzCase result = ResultOf(file);
  EXPECT_EQ(result.result, FuzzResult::kRefused) << result.message;
}

TEST_P(SpecialFiles, ADeviceWithoutEndIsRefused) {
  const fs::path file = Place();
  fs::create_symlink("/dev/zero", file);
  const FuzzCase result = ResultOf(file);
  EXPECT_EQ(result.result, FuzzResult::kRefused) << result.message;
}

TEST_P(SpecialFiles, AFolderIsRefused) {
  const fs::path file = Place();
  fs::create_directory(file);
  const FuzzCase result = ResultOf(file);
  EXPECT_EQ(result.result, FuzzResult::kRefused) << result.message;
}

INSTANTIATE_TEST_SUITE_P(All, SpecialFiles, testing::ValuesIn(Readers()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace pickbed::tests
