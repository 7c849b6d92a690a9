#include "scenes/base/files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// Sets an environment variable until the end of the scope, or unsets it if there is no value.
class WithEnvironment {
 public:
  WithEnvironment(const char* name, const std::optional<std::string>& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    Set(value);
  }
  ~WithEnvironment() { Set(old_); }

 private:
  void Set(const std::optional<std::string>& value) {
    if (value) {
      setenv(name_, value->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }

  const char* name_;
  std::optional<std::string> old_;
};

int FilesIn(const fs::path& folder) {
  return static_cast<int>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(WriteFileAtomically, WritesAndReplacesWithoutOtherFiles) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.bin";
  const std::string bytes("zero\0and\nlines", 14);
  WriteFileAtomically(path, "first and longer than the next one");
  WriteFileAtomically(path, bytes);
  EXPECT_EQ(ReadFileBytes(path), bytes);
  WriteFileAtomically(path, "");
  EXPECT_EQ(ReadFileBytes(path), "");
  EXPECT_EQ(FilesIn(folder.path()), 1);
}

TEST(RequireWritable, RefusesUnusablePathsAndCreatesNothing) {
  const TemporaryFolder folder;
  RequireWritable(folder.path() / "model.net");
  EXPECT_EQ(FilesIn(folder.path()), 0);
  EXPECT_THAT(InputErrorOf([&] { RequireWritable(folder.path()); }), HasSubstr("it is a folder"));
  EXPECT_THAT(InputErrorOf([&] { RequireWritable(folder.path() / "none" / "model.net"); }),
              HasSubstr("No such file"));
}

TEST(WriteFileAtomically, FailsWithPathAndReasonAndLeavesNoFile) {
  const TemporaryFolder folder;
  const fs::path no_folder = folder.path() / "none" / "a.txt";
  EXPECT_THAT(InputErrorOf([&] { WriteFileAtomically(no_folder, "x"); }),
              testing::AllOf(HasSubstr(no_folder.string()), HasSubstr("No such file")));
  const fs::path taken = folder.path() / "taken";  // a folder cannot be replaced by a file
  fs::create_directories(taken / "inside");
  EXPECT_THAT(InputErrorOf([&] { WriteFileAtomically(taken, "x"); }), HasSubstr("Is a directory"));
  EXPECT_TRUE(fs::is_directory(taken / "inside"));
  EXPECT_EQ(FilesIn(folder.path()), 1);
}

TEST(AppendToFile, AddsToTheEndAndNamesTheReasonOfAFailure) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "list.csv";
  AppendToFile(file, "a\n");
  AppendToFile(file, "b\n");
  EXPECT_EQ(ReadFileBytes(file), "a\nb\n");
  EXPECT_THAT(InputErrorOf([] { AppendToFile("/dev/full", "a"); }), HasSubstr("make room"));
  EXPECT_THAT(InputErrorOf([&] { AppendToFile(folder.path() / "no" / "list.csv", "a"); }),
              HasSubstr("choose another folder"));
}

TEST(ReadFileBytes, FailsWithPathAndReason) {
  const TemporaryFolder folder;
  EXPECT_THAT(InputErrorOf([&] { ReadFileBytes(folder.path() / "none.txt"); }),
              HasSubstr("none.txt': No such file"));
  EXPECT_THAT(InputErrorOf([&] { ReadFileBytes(folder.path()); }), HasSubstr("it is a folder"));
}

TEST(AssetsDir, FollowsTheEnvironmentVariable) {
  const TemporaryFolder folder;
  const WithEnvironment assets("PICKBED_ASSETS", folder.path().string());
  EXPECT_EQ(AssetsDir(), folder.path());
  const WithEnvironment wrong("PICKBED_ASSETS", (folder.path() / "none").string());
  EXPECT_THAT(InputErrorOf([] { AssetsDir(); }), HasSubstr("PICKBED_ASSETS names"));
}

TEST(AssetsDir, IsInTheSourceTreeWhenNotInstalled) {
  const WithEnvironment assets("PICKBED_ASSETS", std::nullopt);
  EXPECT_EQ(AssetsDir(), fs::path(PICKBED_SOURCE_DIR) / "assets");
}

TEST(CacheDir, FollowsXdgThenHomeAndCreatesTheFolder) {
  const TemporaryFolder folder;
  const WithEnvironment home("HOME", folder.path().string());
  {
    const WithEnvironment xdg("XDG_CACHE_HOME", (folder.path() / "xdg").string());
    EXPECT_EQ(CacheDir(), folder.path() / "xdg" / "pickbed");
    EXPECT_TRUE(fs::is_directory(folder.path() / "xdg" / "pickbed"));
  }
  for (const std::optional<std::string>& unusable :
       {std::optional<std::string>(), std::optional<std::string>("relative/path")}) {
    const WithEnvironment xdg("XDG_CACHE_HOME", unusable);
    EXPECT_EQ(CacheDir(), folder.path() / ".cache" / "pickbed");
  }
  const WithEnvironment no_home("HOME", std::nullopt);
  const WithEnvironment no_xdg("XDG_CACHE_HOME", std::nullopt);
  EXPECT_THAT(InputErrorOf([] { CacheDir(); }), HasSubstr("set HOME or XDG_CACHE_HOME"));
}

TEST(CacheDir, ErrorGivesTheReason) {
  const TemporaryFolder folder;
  const fs::path file = folder.Write("file", "x");
  const WithEnvironment xdg("XDG_CACHE_HOME", file.string());
  EXPECT_THAT(InputErrorOf([] { CacheDir(); }),
              testing::AllOf(HasSubstr("cache folder"), HasSubstr("Not a directory")));
}

TEST(RemoveTemporaries, RemovesThoseOfDeadProcessesOnly) {
  const TemporaryFolder temporary;
  const std::filesystem::path folder = temporary.path();
  const pid_t dead = fork();
  if (dead == 0) _exit(0);
  waitpid(dead, nullptr, 0);
  std::filesystem::create_directories(folder / "pictures");
  std::filesystem::create_directories(folder / "shard");
  const std::string of_dead = fmt::format("a.png.tmp-{}-0", dead);
  const std::string of_living = fmt::format("a.png.tmp-{}-0", getpid());
  const std::filesystem::path removed = folder / "pictures" / of_dead;
  const std::vector<std::filesystem::path> kept{folder / "pictures" / of_living, folder / "a.png",
                                                folder / "shard" / kLockFile,
                                                folder / "shard" / of_dead, folder / "b.tmp-"};
  WriteFileAtomically(removed, "x");
  for (const std::filesystem::path& file : kept) WriteFileAtomically(file, "x");
  RemoveTemporaries(folder);
  EXPECT_FALSE(std::filesystem::exists(removed));
  for (const std::filesystem::path& file : kept) EXPECT_TRUE(std::filesystem::exists(file)) << file;
}

TEST(ReadFileBytes, RefusesPipesAndDevices) {
  const TemporaryFolder temporary;
  const std::filesystem::path pipe = temporary.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(InputErrorOf([&] { ReadFileBytes(pipe); }), HasSubstr("is no regular file"));
  EXPECT_THAT(InputErrorOf([] { ReadFileBytes("/dev/zero"); }), HasSubstr("no regular file"));
}

}  // namespace
}  // namespace pickbed::tests
