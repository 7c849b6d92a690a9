#include "scenes/base/isolated_call.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

enum Answer : char { kResult = 'r', kInputError = 'e', kNoMemory = 'm', kOther = 'o' };

#if defined(__has_feature)  // clang
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__ 1
#endif
#endif

// Whether a sanitizer maps more address space than any limit.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMapsTerabytes = true;
#else
constexpr bool kMapsTerabytes = false;
#endif

// Bytes of address space that this process has mapped.
size_t MappedBytes() {
  size_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}

void Limit(__rlimit_resource resource, size_t value) {
  const rlimit limit{value, value};
  setrlimit(resource, &limit);
}

void WriteAll(int descriptor, const char* data, size_t size) {
  while (size > 0) {
    const ssize_t written = write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(1);  // the parent is gone or has enough
    data += written;
    size -= static_cast<size_t>(written);
  }
}

// Runs in the child. The importers write to the terminal, and their assertions abort.
[[noreturn]] void WorkInChild(const std::function<std::string()>& work,
                              const IsolationLimits& limits, pid_t parent, int pipe) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  for (const int caught : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTERM, SIGINT, SIGPIPE}) {
    signal(caught, SIG_DFL);
  }
  Limit(RLIMIT_CORE, 0);
  if (!kMapsTerabytes) Limit(RLIMIT_AS, MappedBytes() + limits.memory_bytes);
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, standard);
  Answer answer = kResult;
  std::string bytes;
  try {
    bytes = work();
  } catch (const InputError& error) {
    answer = kInputError;
    bytes = error.what();
  } catch (const std::bad_alloc&) {
    answer = kNoMemory;
  } catch (const std::exception& error) {
    answer = kOther;
    bytes = error.what();
  }
  WriteAll(pipe, reinterpret_cast<const char*>(&answer), 1);
  WriteAll(pipe, bytes.data(), bytes.size());
  _exit(0);
}

// Reads until the end, or until a limit is reached. Returns what went wrong, empty = nothing.
std::string ReadAll(int descriptor, const IsolationLimits& limits, std::string& bytes) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(limits.seconds);
  std::string buffer(1 << 16, '\0');
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    pollfd waited{descriptor, POLLIN, 0};
    const int ready = left.count() > 0 ? poll(&waited, 1, static_cast<int>(left.count())) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return fmt::format("it takes more than {} s", limits.seconds);
    const ssize_t got = read(descriptor, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return "";
    bytes.append(buffer.data(), static_cast<size_t>(got));
    if (bytes.size() > limits.result_bytes) {
      return fmt::format("it gives more than {} MB", limits.result_bytes / 1000000);
    }
  }
}

int StatusOf(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

std::string CallIsolated(const std::function<std::string()>& work, const IsolationLimits& limits) {
  int ends[2];
  CheckInput(pipe2(ends, O_CLOEXEC) == 0,
             fmt::format("cannot make a pipe: {}; close other programs", std::strerror(errno)));
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    WorkInChild(work, limits, parent, ends[1]);
  }
  const int fork_error = errno;
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    throw InputError(
        fmt::format("cannot start a process: {}; close other programs", std::strerror(fork_error)));
  }
  std::string bytes;
  const std::string excess = ReadAll(ends[0], limits, bytes);
  close(ends[0]);
  if (!excess.empty()) kill(child, SIGKILL);
  const int status = StatusOf(child);
  if (!excess.empty()) throw IsolationError(excess);
  if (WIFSIGNALED(status)) {
    throw IsolationError(fmt::format("the process crashed ({})", strsignal(WTERMSIG(status))));
  }
  if (bytes.empty()) throw IsolationError("the process ended without an answer");
  const char answer = bytes.front();
  bytes.erase(0, 1);
  if (answer == kInputError) throw InputError(bytes);
  if (answer == kNoMemory) {
    throw IsolationError(fmt::format("it needs more than {:.1f} GB of memory",
                                     static_cast<double>(limits.memory_bytes) / 1e9));
  }
  if (answer != kResult) throw IsolationError(bytes);
  return bytes;
}

}  // namespace pickbed::scenes
