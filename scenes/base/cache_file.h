#pragma once

// Files of the cache: values that take long to compute and depend only on what is in the name of
// their file. Each has a check sum, is written atomically, and is made again if it is damaged.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "scenes/base/cache_lock.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::scenes {

// Receives one line for each damaged file. The line says what happens instead.
using CacheListener = std::function<void(const std::string& line)>;
// Sets the listener of the process and returns the former one. Without one, damaged files are made
// again silently.
CacheListener SetCacheListener(CacheListener listener);

// Returns the content of a cache file; nullopt if there is none. A file is reported and not used if
// it is damaged, or if it belongs to another user who is not root.
std::optional<std::string> ReadCacheFile(const std::filesystem::path& file);
// Writes content with its check sum, atomically. Throws as WriteFileAtomically().
void WriteCacheFile(const std::filesystem::path& file, std::string_view content);
// Reports a file whose check sum is right, but whose content is not.
void ReportDamagedCacheFile(const std::filesystem::path& file, const std::string& fault);

// Removes unfinished files of killed processes, once per process and folder. Other machines can use
// the same folder, so only files older than a day are removed.
void TidyCacheFolder(const std::filesystem::path& folder);

// Returns the value of a cache file. If there is no usable file, computes the value with `make` and
// stores it. Other processes that need the same value wait for it.
//   read(content)  returns the value; nullopt if it is out of date; throws InputError if the
//                  content has another form
//   write(value)   returns the content
template <typename Read, typename Make, typename Write>
auto Cached(const std::filesystem::path& file, Read&& read, Make&& make, Write&& write) {
  const auto stored = [&]() -> std::optional<decltype(make())> {
    const std::optional<std::string> content = ReadCacheFile(file);
    if (!content) return std::nullopt;
    try {
      return read(*content);
    } catch (const InputError& error) {
      ReportDamagedCacheFile(file, error.what());
      return std::nullopt;
    }
  };
  if (auto value = stored()) return *std::move(value);
  MakeFolder(file.parent_path());
  TidyCacheFolder(file.parent_path());
  const CacheLock lock(file);
  if (auto value = stored()) return *std::move(value);
  auto value = make();
  WriteCacheFile(file, write(value));
  return value;
}

}  // namespace pickbed::scenes
