#include "eval/runtime/results_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

// Workers of a killed run end shortly after it.
constexpr std::chrono::milliseconds kPatience{3000};
constexpr std::chrono::milliseconds kAskEvery{20};

std::string HolderIn(int file) {
  std::array<char, 200> text{};
  const ssize_t got = pread(file, text.data(), text.size() - 1, 0);
  return got > 0 ? std::string(text.data(), got) : "another process";
}

bool TryLock(int file) {
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (flock(file, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return false;
    if (std::chrono::steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(kAskEvery);
  }
  return true;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) {
  MakeFolder(folder);
  const std::string path = (folder / kLockFile).string();
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  CheckInput(file_ >= 0, fmt::format("cannot write to {}: {}; choose another results folder", path,
                                     strerror(errno)));
  if (!TryLock(file_)) {
    const std::string holder = HolderIn(file_);
    close(file_);
    throw InputError(
        fmt::format("{} is in use by {}; wait for it, or choose another results folder",
                    folder.string(), holder));
  }
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  const std::string holder = fmt::format("process {} on {}", getpid(), host.data());
  // The text only serves the error message above, so a failed write is ignored.
  if (ftruncate(file_, 0) == 0) (void)!pwrite(file_, holder.data(), holder.size(), 0);
  RemoveTemporaries(folder);
}

// Workers that are still ending hold the descriptor and so keep the lock.
FolderLock::~FolderLock() { close(file_); }

}  // namespace pickbed::eval
