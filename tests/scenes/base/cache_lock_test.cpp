#include "scenes/base/cache_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <vector>

#include "scenes/base/files.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

class CacheLockTest : public testing::Test {
 protected:
  // Reads the file or makes it, as a user of a cache does. Each process that makes it appends one
  // character to the file `made`.
  void ReadOrMake(useconds_t making_us) const {
    if (std::filesystem::exists(file_)) return;
    const CacheLock lock(file_);
    if (std::filesystem::exists(file_)) return;
    std::ofstream(temporary_.path() / "made", std::ios::app).put('x').flush();
    usleep(making_us);
    WriteFileAtomically(file_, "codes");
  }
  static pid_t Fork(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child != 0) return child;
    work();
    _exit(0);
  }
  static std::filesystem::path LockOf(const std::filesystem::path& file) {
    return file.string() + ".lock";
  }
  std::string Made() const {
    const std::filesystem::path made = temporary_.path() / "made";
    return std::filesystem::exists(made) ? ReadFileBytes(made) : "";
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path file_ = temporary_.path() / "codes.bin";
};

TEST_F(CacheLockTest, OneProcessMakesTheFileAndTheOthersWait) {
  std::vector<pid_t> children;
  for (int i = 0; i < 6; ++i) {
    children.push_back(Fork([&] { ReadOrMake(100000); }));
  }
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(Made(), "x");
  EXPECT_FALSE(std::filesystem::exists(LockOf(file_))) << "the lock file is left over";
}

TEST_F(CacheLockTest, NextProcessMakesTheFileIfTheFirstIsKilled) {
  const pid_t first = Fork([&] { ReadOrMake(60000000); });
  while (Made().empty()) usleep(1000);
  const pid_t second = Fork([&] { ReadOrMake(0); });
  usleep(50000);
  EXPECT_EQ(Made(), "x") << "the second process did not wait";
  kill(first, SIGKILL);
  waitpid(first, nullptr, 0);
  waitpid(second, nullptr, 0);
  EXPECT_EQ(Made(), "xx");
  EXPECT_EQ(ReadFileBytes(file_), "codes");
}

TEST_F(CacheLockTest, LocksOfDifferentFilesAreIndependent) {
  const CacheLock lock(file_);
  const CacheLock other(temporary_.path() / "other.bin");
  EXPECT_TRUE(std::filesystem::exists(LockOf(file_)));
  EXPECT_TRUE(std::filesystem::exists(LockOf(temporary_.path() / "other.bin")));
}

TEST_F(CacheLockTest, MissingFolderNeedsNoLock) {
  const std::filesystem::path missing = temporary_.path() / "nowhere" / "codes.bin";
  const CacheLock lock(missing);
  const CacheLock again(missing);
  EXPECT_FALSE(std::filesystem::exists(missing.parent_path())) << "the folder was created";
}

}  // namespace
}  // namespace pickbed::tests
