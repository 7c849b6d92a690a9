#pragma once

// Locations of the program's assets and cache, and reading and writing of complete files.

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace pickbed::scenes {

// Returns the assets/ folder: the one installed beside the running program, else the one of the
// source tree that the library was built from, else the one installed with the library. The
// environment variable PICKBED_ASSETS overrides all. Throws InputError when no folder exists.
std::filesystem::path AssetsDir();

// Returns the folder of the Python package for plug-ins, beside the assets.
std::filesystem::path PythonDir();

// Returns XDG_CACHE_HOME/pickbed (or ~/.cache/pickbed) and creates it if needed. Throws InputError
// when it cannot be created.
std::filesystem::path CacheDir();

// Returns the sorted stems of the files in `folder` with this extension (such as ".yaml"). The
// result is empty when the folder does not exist.
std::vector<std::string> StemsIn(const std::filesystem::path& folder, const std::string& extension);

// Return whether there is a file or folder, or a regular file. A name that is too long is no file,
// while the functions of the standard library throw.
bool Exists(const std::filesystem::path& path);
bool IsRegularFile(const std::filesystem::path& path);

// Returns the file of a trained model: a path with a folder or an existing .net file, else a file
// in assets/models.
std::filesystem::path TrainedFile(const std::string& name);

// Creates a folder with all its parents, if needed. Throws InputError with the path and the
// system's reason.
void MakeFolder(const std::filesystem::path& folder);

// Returns all bytes of a file. Throws InputError with the path and the system's reason.
std::string ReadFileBytes(const std::filesystem::path& path);
// Returns the text of a file, without the UTF-8 byte order mark with which some programs begin it.
// Throws as ReadFileBytes().
std::string ReadFileText(const std::filesystem::path& path);
inline constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";

// Writes bytes to `path` through a temporary file and an atomic rename. Throws InputError with the
// path and the system's reason (no space left, no permission). The old file then stays unchanged.
void WriteFileAtomically(const std::filesystem::path& path, const std::string& bytes);
// Adds bytes to the end of a file, and creates it if needed. Throws as WriteFileAtomically(); a
// part of the bytes may then be in the file.
void AppendToFile(const std::filesystem::path& path, const std::string& bytes);

// Name of the file whose lock belongs to the one process that may write in its folder.
inline constexpr char kLockFile[] = "lock";

// Removes temporary files of WriteFileAtomically() whose process no longer runs, in a folder and
// below. Sub-folders that have their own lock file are skipped: another machine could write there.
// The caller holds the lock of the folder.
void RemoveTemporaries(const std::filesystem::path& folder);
// Removes unfinished files of any process in a folder, not in its subfolders, if they were not
// written for `age`.
void RemoveOldTemporaries(const std::filesystem::path& folder, std::chrono::hours age);

// Throws InputError when no file can be created at `path`. Call it before long work whose result is
// written there.
void RequireWritable(const std::filesystem::path& path);

}  // namespace pickbed::scenes
