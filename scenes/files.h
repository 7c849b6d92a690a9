#pragma once

// Where the program's own data and caches live, and whole files in and out.

#include <filesystem>
#include <string>
#include <vector>

namespace pickbed {

// assets/ of the source tree or of the installed program, found relative to the executable;
// the environment variable PICKBED_ASSETS overrides it. Throws InputError when there is none.
std::filesystem::path AssetsDir();

// XDG_CACHE_HOME/pickbed (or ~/.cache/pickbed), created on demand. Throws InputError when it
// cannot be made.
std::filesystem::path CacheDir();

// Stems of the files with this extension (".yaml") in a folder, sorted; none where there is no
// folder.
std::vector<std::string> StemsIn(const std::filesystem::path& folder, const std::string& extension);

// All bytes of a file. Throws InputError with the path and the system's reason.
std::string ReadFileBytes(const std::filesystem::path& path);

// Writes bytes to `path` through a temporary file and an atomic rename. Throws InputError with the
// path and the system's reason (no space left, no permission) and leaves the old file whole.
void WriteFileAtomically(const std::filesystem::path& path, const std::string& bytes);

// Before long work whose result goes to `path`: throws InputError when no file can be made there.
void RequireWritable(const std::filesystem::path& path);

}  // namespace pickbed
