// Names and paths that point out of the folder of a dataset, a store or a catalog. They must not
// make the program write, or find objects, elsewhere.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/bop/check_dataset.h"
#include "eval/bop/dataset_scores.h"
#include "eval/store/results_store.h"
#include "eval/store/sqlite.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/merge_shards.h"
#include "scenes/base/error.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/objects/object_catalog.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/eval/stub_sweep.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kWaysOut[] = {"../outside", "../../outside", "/outside", "a/../../outside",
                                    ".."};

// All files below a folder, with their contents.
std::map<std::string, std::string> FilesBelow(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] = ReadFileBytes(entry.path());
  }
  return files;
}

TEST(Paths, FileNamesOfConfigurationsHaveNoFolder) {
  for (const std::string name : kWaysOut) {
    const std::string file = ConfigurationFileName(0, name);
    EXPECT_EQ(file.find('/'), std::string::npos) << file;
    EXPECT_EQ(fs::path(file).filename(), file);
    EXPECT_FALSE(file.starts_with(".")) << file;
  }
  EXPECT_EQ(ConfigurationFileName(0, "a\\b\nc").find_first_of("\\\n"), std::string::npos);
}

TEST(Paths, NamesOfObjectsDoNotLeaveTheCatalog) {
  const TemporaryFolder temporary;
  constexpr const char* kObject = "mesh: mesh.obj\nunit: m\nmass_kg: 0.1\nfriction: 0.5\n";
  constexpr const char* kMesh =
      "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  for (const char* folder : {"catalog/inside", "outside", "catalog/a"}) {
    temporary.Write(std::string(folder) + "/object.yaml", kObject);
    temporary.Write(std::string(folder) + "/mesh.obj", kMesh);
  }
  const ObjectCatalog catalog({temporary.path() / "catalog"});
  EXPECT_EQ(catalog.Load("inside")->name, "inside");
  for (const std::string name : kWaysOut) {
    EXPECT_THAT(ErrorOf([&] { catalog.Load(name); }), HasSubstr("unknown object")) << name;
  }
  const std::string absolute = (temporary.path() / "outside").string();
  EXPECT_THAT(ErrorOf([&] { catalog.Load(absolute); }), HasSubstr("unknown object"));
}

// A store with a configuration whose name is a path is merged beside a folder of somebody.
TEST(Paths, NamesInAStoreDoNotLeaveTheFolderOfAMerge) {
  for (const std::string name : kWaysOut) {
    const TemporaryFolder temporary;
    const fs::path store = temporary.path() / "store", out = temporary.path() / "in" / "merged";
    temporary.Write("outside", "mine");
    temporary.Write("in/outside", "mine");
    fs::create_directories(store);
    Sweep sweep = StubSweep(1, 2);
    sweep.configurations.front().name = name;
    {
      ResultsStore results(store, HeadOf(sweep, store));
      for (int number = 0; number < 2; ++number) {
        TrialResult trial = FullTrial(number);
        trial.instances_cleared = 0;  // none of its attempts succeeds
        results.Write(trial);
      }
    }
    const auto before = FilesBelow(temporary.path());
    EXPECT_EQ(MergeStores({store}, out).trials, 2) << name;
    for (const auto& [file, bytes] : FilesBelow(temporary.path())) {
      if (file.starts_with("in/merged/")) continue;
      ASSERT_TRUE(before.contains(file)) << file << " is new";
      EXPECT_TRUE(file.starts_with("store/") || before.at(file) == bytes) << file;
    }
    EXPECT_FALSE(fs::exists("/outside"));
  }
}

// Datasets have numbers in place of paths, so that a text there is refused with its file.
TEST(Paths, NumbersOfADatasetCannotBePaths) {
  const TemporaryFolder small;
  MakeSmall(small.path(), 1, 2);
  struct Case {
    const char* file;
    std::string number, text;
  };
  const Case cases[] = {{"test_targets_bop19.json", "\"scene_id\":1", "\"scene_id\":\"{}\""},
                        {"test_targets_bop19.json", "\"im_id\":1", "\"im_id\":\"{}\""},
                        {"test/000001/scene_camera.json", "\"1\":", "\"{}\":"},
                        {"test/000001/scene_gt.json", "\"1\":", "\"{}\":"},
                        {"models/models_info.json", "\"1\":", "\"{}\":"}};
  for (const Case& test : cases) {
    for (const std::string name : kWaysOut) {
      const TemporaryFolder temporary;
      const fs::path root = temporary.path() / "set";
      fs::copy(small.path(), root, fs::copy_options::recursive);
      std::string json = ReadFileBytes(root / test.file);
      std::erase(json, ' ');
      const size_t at = json.find(test.number);
      ASSERT_NE(at, std::string::npos) << test.file << ": " << json;
      json.replace(at, test.number.size(), fmt::format(fmt::runtime(test.text), name));
      WriteFileAtomically(root / test.file, json);
      const std::vector<std::string> faults = CheckDataset(root).faults;
      EXPECT_THAT(faults, testing::Contains(HasSubstr(test.file))) << name;
      if (std::string(test.file).starts_with("models/")) continue;  // scores do not read it
      EXPECT_THROW(EvaluateDataset(root, "test", {}), InputError) << test.file << " " << name;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
