#pragma once

// Protects a results folder against two concurrent runs.

#include <filesystem>
#include <string>

#include "eval/layer.h"

namespace pickbed::eval {

// Lock on FOLDER/lock, held from construction to destruction. The system releases it when the
// process and its forked workers have ended, so a crash leaves no lock behind. The file remains and
// has no meaning.
class FolderLock {
 public:
  // Creates the folder and locks it. Throws InputError if another process holds the lock (also on
  // another machine that shares the folder), or if the folder is not writable.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace pickbed::eval
