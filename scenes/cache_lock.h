#pragma once

// One process makes what a cache's file holds while others that need it wait.

#include <filesystem>

namespace pickbed {

// Held from construction to destruction by one process, or thread, at a time, for each `file`; also
// over machines that share the folder, where its file system can lock. Look for the file again once
// it is held. Lies in FILE.lock, which is gone when nobody holds it or waits; a process that dies
// lets go of it. Where no lock can be had none is waited for: all make the same bytes, and the file
// is renamed into its place.
class CacheLock {
 public:
  explicit CacheLock(const std::filesystem::path& file);
  ~CacheLock();
  CacheLock(const CacheLock&) = delete;
  CacheLock& operator=(const CacheLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace pickbed
