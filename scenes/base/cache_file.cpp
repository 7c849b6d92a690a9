#include "scenes/base/cache_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <mutex>
#include <set>
#include <utility>

#include "scenes/base/byte_blocks.h"

namespace pickbed::scenes {
namespace {

constexpr std::string_view kMagic = "PICKCACH";
constexpr uint64_t kVersion = 1;

CacheListener& DamageListener() {
  static CacheListener listener;
  return listener;
}

// Another user could have written any content, with a right check sum.
bool BelongsToAnotherUser(const std::filesystem::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) return false;
  return status.st_uid != geteuid() && status.st_uid != 0;
}

}  // namespace

CacheListener SetCacheListener(CacheListener listener) {
  return std::exchange(DamageListener(), std::move(listener));
}

void TidyCacheFolder(const std::filesystem::path& folder) {
  constexpr std::chrono::hours kDay(24);
  static std::mutex mutex;
  static std::set<std::filesystem::path> tidied;
  {
    const std::scoped_lock lock(mutex);
    if (!tidied.insert(folder).second) return;
  }
  RemoveOldTemporaries(folder, kDay);
}

void ReportDamagedCacheFile(const std::filesystem::path& file, const std::string& fault) {
  if (DamageListener()) {
    DamageListener()(fmt::format("{}: {}; it is made again", file.string(), fault));
  }
}

std::optional<std::string> ReadCacheFile(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::nullopt;
  if (BelongsToAnotherUser(file)) {
    ReportDamagedCacheFile(file, "the file belongs to another user");
    return std::nullopt;
  }
  try {
    const std::string bytes = ReadFileBytes(file);
    BlockReader reader(bytes, kMagic, kVersion, "a file of the cache");
    const std::string content(reader.Take());
    reader.RequireEnd();
    return content;
  } catch (const InputError& fault) {
    ReportDamagedCacheFile(file, fault.what());
    return std::nullopt;
  }
}

void WriteCacheFile(const std::filesystem::path& file, std::string_view content) {
  BlockWriter writer;
  writer.Put(content);
  WriteFileAtomically(file, writer.Bytes(kMagic, kVersion));
}

}  // namespace pickbed::scenes
