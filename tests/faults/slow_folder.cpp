// A library for LD_PRELOAD that makes one folder behave like a bad shared folder (NFS).
//
//   SLOW_FOLDER            the folder, an absolute path; other files are untouched
//   SLOW_FOLDER_STATE      a file of 8 bytes that all processes share: the number of calls so far
//   SLOW_FOLDER_DELAY_US   each call waits up to this time, differently for each
//   SLOW_FOLDER_LATE_US    a file that a process did not find stays hidden from it for this time,
//                          also if another process has made it meanwhile
//   SLOW_FOLDER_FAIL_AT    the call of this number fails, 1 = the first
//   SLOW_FOLDER_ERRNO      with this error
//   SLOW_FOLDER_READ_ONLY_FROM  from the call of this number on, nothing can be written (EROFS)

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>

namespace {

long Number(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? 0 : std::atol(value);
}

template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

struct Settings {
  std::string folder;
  long delay_us = Number("SLOW_FOLDER_DELAY_US"), late_us = Number("SLOW_FOLDER_LATE_US");
  long fail_at = Number("SLOW_FOLDER_FAIL_AT"), error = Number("SLOW_FOLDER_ERRNO");
  long read_only_from = Number("SLOW_FOLDER_READ_ONLY_FROM");
  std::atomic<int64_t>* calls = nullptr;  // shared by all processes

  Settings() {
    const char* const name = std::getenv("SLOW_FOLDER");
    const char* const state = std::getenv("SLOW_FOLDER_STATE");
    if (name == nullptr || state == nullptr) return;
    const int file = Next<int(const char*, int, ...)>("open")(state, O_RDWR | O_CLOEXEC);
    if (file < 0) return;
    void* const shared = mmap(nullptr, sizeof(*calls), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (shared == MAP_FAILED) return;
    calls = static_cast<std::atomic<int64_t>*>(shared);
    folder = name;
  }
};

const Settings& Given() {
  static const Settings* const settings = new Settings;  // used until the end of the process
  return *settings;
}

bool IsInside(const std::string& path) {
  const std::string& folder = Given().folder;
  return !folder.empty() && path.compare(0, folder.size(), folder) == 0 &&
         (path.size() == folder.size() || path[folder.size()] == '/');
}

std::string PathOf(int file) {
  char path[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const ssize_t size = readlink(link.c_str(), path, sizeof path);
  return size > 0 ? std::string(path, static_cast<size_t>(size)) : std::string();
}

std::string PathOf(int folder, const char* name) {
  if (name[0] == '/') return name;
  char here[4096];
  if (folder != AT_FDCWD) return PathOf(folder) + "/" + name;
  return getcwd(here, sizeof here) == nullptr ? name : std::string(here) + "/" + name;
}

// Counts and delays a call on a path. Returns whether the call must fail; errno is then set.
bool Fails(const std::string& path, bool writes) {
  if (!IsInside(path)) return false;
  const Settings& given = Given();
  const int64_t number = ++*given.calls;
  if (given.delay_us > 0) {
    usleep(static_cast<useconds_t>(number * 7919 % given.delay_us));  // a prime spreads them
  }
  if (writes && given.read_only_from > 0 && number >= given.read_only_from) {
    errno = EROFS;
    return true;
  }
  if (number != given.fail_at) return false;
  errno = static_cast<int>(given.error);
  return true;
}

// Paths that this process has not found, with the time.
class Missing {
 public:
  static Missing& Paths() {
    static Missing* const paths = new Missing;
    return *paths;
  }
  bool Hides(const std::string& path) {
    if (Given().late_us <= 0 || !IsInside(path)) return false;
    const std::lock_guard lock(mutex_);
    const auto found = since_.find(path);
    return found != since_.end() && Clock::now() - found->second < Late();
  }
  // Keeps the first time until the path is found.
  void Note(const std::string& path, bool is_found) {
    if (Given().late_us <= 0 || !IsInside(path)) return;
    const std::lock_guard lock(mutex_);
    if (is_found) {
      since_.erase(path);
    } else {
      since_.insert_or_assign(path, Clock::now());
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  static std::chrono::microseconds Late() { return std::chrono::microseconds(Given().late_us); }
  std::mutex mutex_;
  std::map<std::string, Clock::time_point> since_;
};

// Finds a path with `try_it`, which returns -1 for failure.
template <typename Try>
int Find(const std::string& path, const Try& try_it, bool writes = false) {
  if (Fails(path, writes)) return -1;
  if (Missing::Paths().Hides(path)) {
    errno = ENOENT;
    return -1;
  }
  const int result = try_it();
  const int error = errno;
  Missing::Paths().Note(path, result >= 0 || error != ENOENT);
  errno = error;
  return result;
}

// Opens a file. What a process makes itself, it sees at once.
template <typename Open>
int OpenFile(const std::string& path, int flags, const Open& open) {
  const bool writes = (flags & (O_CREAT | O_WRONLY | O_RDWR)) != 0;
  if ((flags & O_CREAT) == 0) return Find(path, open, writes);
  if (Fails(path, writes)) return -1;
  const int result = open();
  if (result >= 0) Missing::Paths().Note(path, true);
  return result;
}

mode_t ModeOf(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

#define OPEN(name)                                                                           \
  extern "C" int name(const char* path, int flags, ...) {                                    \
    va_list arguments;                                                                       \
    va_start(arguments, flags);                                                              \
    const mode_t mode = ModeOf(flags, arguments);                                            \
    va_end(arguments);                                                                       \
    static const auto next = Next<int(const char*, int, ...)>(#name);                        \
    return OpenFile(PathOf(AT_FDCWD, path), flags, [&] { return next(path, flags, mode); }); \
  }
OPEN(open)
OPEN(open64)

#define FOPEN(name)                                                        \
  extern "C" FILE* name(const char* path, const char* mode) {              \
    static const auto next = Next<FILE*(const char*, const char*)>(#name); \
    FILE* file = nullptr;                                                  \
    OpenFile(PathOf(AT_FDCWD, path), mode[0] == 'r' ? 0 : O_CREAT, [&] {   \
      file = next(path, mode);                                             \
      return file == nullptr ? -1 : 0;                                     \
    });                                                                    \
    return file;                                                           \
  }
FOPEN(fopen)
FOPEN(fopen64)

#define STAT(name, Status)                                                   \
  extern "C" int name(const char* path, struct Status* status) noexcept {    \
    static const auto next = Next<int(const char*, struct Status*)>(#name);  \
    return Find(PathOf(AT_FDCWD, path), [&] { return next(path, status); }); \
  }
STAT(stat, stat)
STAT(stat64, stat64)
STAT(lstat, stat)
STAT(lstat64, stat64)

extern "C" int access(const char* path, int mode) noexcept {
  static const auto next = Next<int(const char*, int)>("access");
  return Find(PathOf(AT_FDCWD, path), [&] { return next(path, mode); });
}

extern "C" int rename(const char* from, const char* to) noexcept {
  static const auto next = Next<int(const char*, const char*)>("rename");
  const std::string path = PathOf(AT_FDCWD, to);
  if (Fails(path, true)) return -1;
  const int result = next(from, to);
  if (result == 0) Missing::Paths().Note(path, true);
  return result;
}

#define ON_PATH(name)                                             \
  extern "C" int name(const char* path) noexcept {                \
    static const auto next = Next<int(const char*)>(#name);       \
    return Fails(PathOf(AT_FDCWD, path), true) ? -1 : next(path); \
  }
ON_PATH(unlink)
ON_PATH(rmdir)

extern "C" int mkdir(const char* path, mode_t mode) noexcept {
  static const auto next = Next<int(const char*, mode_t)>("mkdir");
  const std::string name = PathOf(AT_FDCWD, path);
  if (Fails(name, true)) return -1;
  const int result = next(path, mode);
  if (result == 0) Missing::Paths().Note(name, true);
  return result;
}

#define ON_FILE(name)                                    \
  extern "C" int name(int file) {                        \
    static const auto next = Next<int(int)>(#name);      \
    return Fails(PathOf(file), false) ? -1 : next(file); \
  }
ON_FILE(fsync)
ON_FILE(fdatasync)

extern "C" ssize_t write(int file, const void* data, size_t size) {
  static const auto next = Next<ssize_t(int, const void*, size_t)>("write");
  return Fails(PathOf(file), true) ? -1 : next(file, data, size);
}

#define TRANSFER(name, Data, Offset, writes)                                  \
  extern "C" ssize_t name(int file, Data data, size_t size, Offset offset) {  \
    static const auto next = Next<ssize_t(int, Data, size_t, Offset)>(#name); \
    return Fails(PathOf(file), writes) ? -1 : next(file, data, size, offset); \
  }
TRANSFER(pwrite, const void*, off_t, true)
TRANSFER(pwrite64, const void*, off64_t, true)
TRANSFER(pread, void*, off_t, false)
TRANSFER(pread64, void*, off64_t, false)
