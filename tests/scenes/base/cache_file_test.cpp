#include "scenes/base/cache_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/support/block_file.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CacheFile : public testing::Test {
 protected:
  CacheFile() {
    SetCacheListener([this](const std::string& line) { lines_.push_back(line); });
  }
  ~CacheFile() override { SetCacheListener({}); }
  // Returns the cached number, or makes it and counts that.
  int Number() {
    return Cached(
        file_,
        [](const std::string& content) -> std::optional<int> {
          if (content == "old") return std::nullopt;
          CheckInput(content == "42", "it is no number");
          return 42;
        },
        [this] {
          ++made_;
          return 42;
        },
        [](int value) { return std::to_string(value); });
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path file_ = temporary_.path() / "numbers" / "n.txt";
  std::vector<std::string> lines_;
  int made_ = 0;
};

TEST_F(CacheFile, IsMadeOnce) {
  EXPECT_EQ(Number(), 42);
  EXPECT_EQ(Number(), 42);
  EXPECT_EQ(made_, 1);
  EXPECT_THAT(lines_, IsEmpty());
}

TEST_F(CacheFile, EveryFlippedBitAndEveryCutIsNoticedAndRepaired) {
  Number();
  const std::string bytes = ReadFileBytes(file_);
  const size_t version = 8;  // a lower version is accepted
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    if (bit == 8 * version) continue;
    std::string damaged = bytes;
    damaged[bit / 8] ^= 1 << bit % 8;
    WriteFileAtomically(file_, damaged);
    EXPECT_FALSE(ReadCacheFile(file_).has_value()) << bit;
  }
  for (size_t size = 0; size < bytes.size(); ++size) {
    WriteFileAtomically(file_, bytes.substr(0, size));
    EXPECT_FALSE(ReadCacheFile(file_).has_value()) << size;
  }
  lines_.clear();
  EXPECT_EQ(Number(), 42);
  EXPECT_EQ(made_, 2);
  EXPECT_EQ(ReadFileBytes(file_), bytes);
  ASSERT_FALSE(lines_.empty());
  EXPECT_THAT(lines_.front(), HasSubstr("n.txt: the file is cut short"));
  EXPECT_THAT(lines_.front(), HasSubstr("it is made again"));
}

TEST_F(CacheFile, BytesAfterTheEndAreNoticed) {
  Number();
  const std::string bytes = ReadFileBytes(file_);
  WriteFileAtomically(file_, WithRightHash(bytes));
  EXPECT_TRUE(ReadCacheFile(file_).has_value());
  WriteFileAtomically(file_, WithRightHash(bytes + "x"));
  EXPECT_FALSE(ReadCacheFile(file_).has_value());
  EXPECT_THAT(lines_.back(), HasSubstr("it is longer than its blocks"));
}

TEST_F(CacheFile, ContentOfAnotherFormIsReportedAndOldContentIsNot) {
  Number();
  WriteCacheFile(file_, "forty");
  EXPECT_EQ(Number(), 42);
  EXPECT_THAT(lines_.front(), HasSubstr("it is no number"));
  lines_.clear();
  WriteCacheFile(file_, "old");
  EXPECT_EQ(Number(), 42);
  EXPECT_EQ(made_, 3);
  EXPECT_THAT(lines_, IsEmpty());
}

TEST_F(CacheFile, FilesOfAnotherUserAreNotUsed) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a file to another user";
  Number();
  ASSERT_EQ(chown(file_.c_str(), 12345, 12345), 0);
  EXPECT_FALSE(ReadCacheFile(file_).has_value());
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_THAT(lines_[0], HasSubstr("belongs to another user"));
}

TEST_F(CacheFile, OldUnfinishedFilesAreRemovedWhenAValueIsMade) {
  const std::string old = file_.string() + ".tmp-1-0", recent = file_.string() + ".tmp-1-1",
                    other = file_.string() + ".copy";
  MakeFolder(file_.parent_path());
  const auto now = std::filesystem::file_time_type::clock::now();
  for (const std::string& name : {old, recent, other}) {
    WriteFileAtomically(name, "half");
    std::filesystem::last_write_time(name, now - std::chrono::hours(name == recent ? 23 : 25));
  }
  EXPECT_EQ(Number(), 42);
  EXPECT_FALSE(std::filesystem::exists(old));
  EXPECT_TRUE(std::filesystem::exists(recent)) << "a process of another machine may write it";
  EXPECT_TRUE(std::filesystem::exists(other)) << "it is no unfinished file";
}

}  // namespace
}  // namespace pickbed::tests
