#pragma once

// A lock per cache file: one process computes the content of the file while the others wait for it.

#include <filesystem>

namespace pickbed::scenes {

// Lock on a cache file `file`, held from construction to destruction by one process or thread at a
// time. It also works between machines that share the folder, if the file system supports locks.
// The caller must check again whether the file exists after it has obtained the lock.
//
// The lock is the file FILE.lock, which is removed when the lock is released. The lock of a process
// that dies is released. If no lock can be obtained, the constructor returns without one. This is
// safe, because all processes produce the same bytes and rename the finished file into place.
class CacheLock {
 public:
  // Waits until the lock is obtained, or returns at once if locks are not possible.
  explicit CacheLock(const std::filesystem::path& file);
  ~CacheLock();
  CacheLock(const CacheLock&) = delete;
  CacheLock& operator=(const CacheLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace pickbed::scenes
