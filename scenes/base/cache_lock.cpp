#include "scenes/base/cache_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace pickbed::scenes {
namespace {

bool Lock(int descriptor) {
  while (flock(descriptor, LOCK_EX) != 0) {
    if (errno != EINTR) return false;
  }
  return true;
}

// The previous holder may have removed the file; other processes then lock a new one at this path.
bool IsStillThere(int descriptor, const std::filesystem::path& path) {
  struct stat mine {
  }, there{};
  return fstat(descriptor, &mine) == 0 && stat(path.c_str(), &there) == 0 &&
         mine.st_ino == there.st_ino && mine.st_dev == there.st_dev;
}

}  // namespace

CacheLock::CacheLock(const std::filesystem::path& file) : path_(file) {
  path_ += ".lock";
  for (;;) {
    descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) return;
    const bool locked = Lock(descriptor_);
    if (locked && IsStillThere(descriptor_, path_)) return;
    close(descriptor_);
    descriptor_ = -1;
    if (!locked) return;
  }
}

CacheLock::~CacheLock() {
  if (descriptor_ < 0) return;
  unlink(path_.c_str());
  close(descriptor_);
}

}  // namespace pickbed::scenes
