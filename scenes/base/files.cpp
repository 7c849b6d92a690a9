#include "scenes/base/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

fs::path EnvironmentPath(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? fs::path() : fs::path(value);
}

// The folder of the running program; empty where /proc is absent.
fs::path ExecutableDir() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

const char* WhatToDo(int error) {
  if (error == ENOSPC || error == EDQUOT) return "; make room and repeat the command";
  if (error == ENOENT || error == ESTALE || error == EIO) {
    return "; its folder was removed or cannot be reached; make it available again, or choose "
           "another folder";
  }
  if (error == EROFS || error == EACCES || error == EPERM) return "; choose another folder";
  return "";
}

[[noreturn]] void ThrowNotWritten(const fs::path& path) {
  const int error = errno;
  throw InputError("cannot write '" + path.string() + "': " + std::strerror(error) +
                   WhatToDo(error));
}

void WriteAll(int descriptor, const std::string& bytes, const fs::path& path) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = write(descriptor, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) ThrowNotWritten(path);
    done += static_cast<size_t>(written);
  }
}

// After it, a power loss takes nothing away.
void Synchronize(int descriptor, const fs::path& path) {
  if (fsync(descriptor) != 0 && errno != EINVAL) ThrowNotWritten(path);  // EINVAL: no disk file
}

// In the name of a temporary file, before the process id.
constexpr std::string_view kTemporary = ".tmp-";

// A temporary file beside the target, removed unless it was renamed away.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& target) : target_(target) {
    // The process id and a counter make the name unique over workers and threads.
    static std::atomic<unsigned> counter{0};
    path_ = fmt::format("{}{}{}-{}", target.string(), kTemporary, getpid(), counter++);
    descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) ThrowNotWritten(target_);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ >= 0) close(descriptor_);
    if (!path_.empty()) unlink(path_.c_str());
  }

  void Write(const std::string& bytes) {
    WriteAll(descriptor_, bytes, target_);
    Synchronize(descriptor_, target_);
  }

  void RenameToTarget() {
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (close(descriptor) != 0 || rename(path_.c_str(), target_.c_str()) != 0) {
      ThrowNotWritten(target_);
    }
    path_.clear();
  }

 private:
  fs::path target_;
  fs::path path_;
  int descriptor_ = -1;
};

}  // namespace

fs::path AssetsDir() {
  const fs::path from_environment = EnvironmentPath("PICKBED_ASSETS");
  if (!from_environment.empty()) {
    CheckInput(fs::is_directory(from_environment),
               "PICKBED_ASSETS names '" + from_environment.string() + "', which is not a folder");
    return from_environment;
  }
  const fs::path near_program = (ExecutableDir() / PICKBED_ASSETS_NEAR_PROGRAM).lexically_normal();
  std::string searched;
  for (const fs::path& folder :
       {near_program, fs::path(PICKBED_SOURCE_ASSETS), fs::path(PICKBED_INSTALLED_ASSETS)}) {
    if (fs::is_directory(folder)) return folder;
    searched += (searched.empty() ? "'" : ", '") + folder.string() + "'";
  }
  throw InputError("found no assets at " + searched + "; set PICKBED_ASSETS to the assets folder");
}

fs::path PythonDir() {
  const fs::path root = AssetsDir().parent_path();
  const fs::path in_sources = root / "scenes" / "plugin" / "python";
  return fs::is_directory(in_sources) ? in_sources : root / "python";  // installed
}

fs::path CacheDir() {
  // The XDG specification requires that a relative XDG_CACHE_HOME is ignored.
  fs::path base = EnvironmentPath("XDG_CACHE_HOME");
  if (!base.is_absolute()) {
    const fs::path home = EnvironmentPath("HOME");
    CheckInput(!home.empty(), "no folder for the cache is known; set HOME or XDG_CACHE_HOME");
    base = home / ".cache";
  }
  const fs::path folder = base / "pickbed";
  std::error_code error;
  fs::create_directories(folder, error);
  CheckInput(!error, "cannot make the cache folder '" + folder.string() + "': " + error.message());
  return folder;
}

std::filesystem::path TrainedFile(const std::string& name) {
  const std::filesystem::path path = name;
  if (path.has_parent_path()) return path;
  if (path.extension() == ".net" && std::filesystem::exists(path)) return path;
  return AssetsDir() / "models" / (path.extension() == ".net" ? name : name + ".net");
}

std::vector<std::string> StemsIn(const std::filesystem::path& folder,
                                 const std::string& extension) {
  std::vector<std::string> stems;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == extension) stems.push_back(entry.path().stem().string());
  }
  std::sort(stems.begin(), stems.end());
  return stems;
}

bool Exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

bool IsRegularFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  CheckInput(!error, "cannot make the folder " + folder.string() + ": " + error.message() +
                         "; choose another folder");
}

std::string ReadFileBytes(const fs::path& path) {
  std::error_code error;
  CheckInput(!fs::is_directory(path, error), "cannot read '" + path.string() + "': it is a folder");
  // A pipe would wait, a device would not end.
  CheckInput(!Exists(path) || IsRegularFile(path),
             "cannot read '" + path.string() + "': it is no regular file; copy its content to one");
  std::ifstream file(path, std::ios::binary);
  CheckInput(file.good(), "cannot read '" + path.string() + "': " + std::strerror(errno));
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return std::move(bytes).str();
}

std::string ReadFileText(const fs::path& path) {
  std::string text = ReadFileBytes(path);
  if (text.starts_with(kByteOrderMark)) text.erase(0, std::strlen(kByteOrderMark));
  return text;
}

void RequireWritable(const fs::path& path) {
  CheckInput(!fs::is_directory(path), "cannot write '" + path.string() + "': it is a folder");
  const TemporaryFile probe(path);
}

void RemoveTemporaries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> left;
  for (fs::recursive_directory_iterator next(folder, error), end; !error && next != end;
       next.increment(error)) {
    if (next->is_directory(error) && Exists(next->path() / kLockFile)) {
      next.disable_recursion_pending();
      continue;
    }
    const std::string name = next->path().filename().string();
    const size_t at = name.rfind(kTemporary);
    if (at == std::string::npos || !next->is_regular_file(error)) continue;
    const pid_t process = std::atoi(name.c_str() + at + kTemporary.size());
    if (process > 0 && kill(process, 0) != 0 && errno == ESRCH) left.push_back(next->path());
  }
  for (const fs::path& file : left) fs::remove(file, error);
}

void RemoveOldTemporaries(const fs::path& folder, std::chrono::hours age) {
  std::error_code error;
  std::vector<fs::path> left;
  for (fs::directory_iterator next(folder, error), end; !error && next != end;
       next.increment(error)) {
    if (next->path().filename().string().rfind(kTemporary) == std::string::npos) continue;
    if (!next->is_regular_file(error)) continue;
    const fs::file_time_type written = next->last_write_time(error);
    if (!error && written < fs::file_time_type::clock::now() - age) left.push_back(next->path());
    error.clear();
  }
  for (const fs::path& file : left) fs::remove(file, error);
}

void WriteFileAtomically(const fs::path& path, const std::string& bytes) {
  TemporaryFile file(path);
  file.Write(bytes);
  file.RenameToTarget();
}

void AppendToFile(const fs::path& path, const std::string& bytes) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0) ThrowNotWritten(path);
  try {
    WriteAll(descriptor, bytes, path);
    Synchronize(descriptor, path);
  } catch (...) {
    close(descriptor);
    throw;
  }
  // A full disk may be reported only now.
  if (close(descriptor) != 0) ThrowNotWritten(path);
}

}  // namespace pickbed::scenes
