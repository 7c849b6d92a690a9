#pragma once

// Keeps two runs out of one results folder.

#include <filesystem>

namespace pickbed {

// Holds FOLDER/lock from construction to destruction. The system lets go of it when the process
// and the workers that it forked are gone, however they ended, so that a crash leaves no lock
// behind; the file stays and means nothing.
class FolderLock {
 public:
  // Makes the folder. Throws InputError when another process holds it, also on another machine
  // where the folder is shared, or when it cannot be written to.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace pickbed
