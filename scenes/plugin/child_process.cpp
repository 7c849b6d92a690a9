#include "scenes/plugin/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/close_range.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <thread>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::scenes {
namespace {

constexpr std::chrono::milliseconds kCheckEvery{2};

// Pipe whose ends are closed at the end, unless they were taken.
struct Pipe {
  Pipe() {
    if (pipe2(ends, O_CLOEXEC) != 0) {
      throw std::runtime_error(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
    }
  }
  ~Pipe() {
    Close(0);
    Close(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int Take(int end) { return std::exchange(ends[end], -1); }
  void Close(int end) {
    if (ends[end] >= 0) close(Take(end));
  }
  int ends[2];
};

std::vector<char*> Pointers(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

// Own variables first: getenv() finds the first one.
std::vector<std::string> EnvironmentWith(std::vector<std::string> own) {
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string name(*entry, std::strcspn(*entry, "=") + 1);
    const bool replaced = std::any_of(own.begin(), own.end(), [&](const std::string& variable) {
      return variable.starts_with(name);
    });
    if (!replaced) own.emplace_back(*entry);
  }
  return own;
}

void CloseOnExec(int first) {
  if (close_range(first, ~0U, CLOSE_RANGE_CLOEXEC) == 0) return;
  const int last = static_cast<int>(std::min(sysconf(_SC_OPEN_MAX), 65536L));
  for (int descriptor = first; descriptor < last; ++descriptor) {
    fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  }
}

struct Launch {
  char* const* arguments;
  char* const* environment;
  int input, output, log, failure;  // descriptors; `failure` gets the error number
  pid_t parent;
};

// Runs in the forked child, where only async-signal-safe functions may be called.
[[noreturn]] void Become(const Launch& launch) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != launch.parent) _exit(1);
  // Above the standard descriptors first, because a process whose own ones are closed gets their
  // numbers for pipes.
  constexpr int kFree = STDERR_FILENO + 1;
  const int input = fcntl(launch.input, F_DUPFD, kFree);
  const int output = fcntl(launch.output, F_DUPFD, kFree);
  const int log = fcntl(launch.log, F_DUPFD, kFree);
  const int failure = fcntl(launch.failure, F_DUPFD, kFree);
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  CloseOnExec(kFree);
  for (const int ignored : {SIGINT, SIGTERM, SIGPIPE}) signal(ignored, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  environ = const_cast<char**>(launch.environment);
  execvp(launch.arguments[0], launch.arguments);
  const int error = errno;
  if (write(failure, &error, sizeof(error)) < 0) _exit(1);
  _exit(1);
}

void ReapFor(pid_t pid) {
  while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
  }
}

// Returns 0 when the program was started, else the error number.
int StartError(int failure) {
  int error = 0;
  ssize_t got = 0;
  do {
    got = read(failure, &error, sizeof(error));
  } while (got < 0 && errno == EINTR);
  return got == sizeof(error) ? error : 0;
}

std::string EndInWords(const siginfo_t& end) {
  if (end.si_code == CLD_EXITED) return fmt::format("ended with status {}", end.si_status);
  return fmt::format("was ended by signal {} ({})", end.si_status, strsignal(end.si_status));
}

}  // namespace

ChildLog::ChildLog(const std::filesystem::path& folder, const std::string& name) {
  if (folder.empty()) {
    descriptor_ = memfd_create(name.c_str(), MFD_CLOEXEC);
    CheckInput(descriptor_ >= 0,
               fmt::format("cannot make a log in memory: {}", std::strerror(errno)));
    return;
  }
  MakeFolder(folder);
  for (int number = 1; descriptor_ < 0; ++number) {
    file_ = folder / fmt::format("{}_{}.log", name, number);
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
    CheckInput(descriptor_ >= 0 || errno == EEXIST,
               fmt::format("cannot write '{}': {}", file_.string(), std::strerror(errno)));
  }
}

ChildLog::~ChildLog() {
  if (!file_.empty() && lseek(descriptor_, 0, SEEK_END) == 0) unlink(file_.c_str());
  close(descriptor_);
}

void ChildLog::Mark() { begin_ = lseek(descriptor_, 0, SEEK_END); }

std::vector<std::string> ChildLog::LastLines(size_t max_lines) const {
  constexpr off_t kMaxBytes = 1 << 16;
  const off_t end = lseek(descriptor_, 0, SEEK_END);
  std::string text(std::clamp<off_t>(end - begin_, 0, kMaxBytes), '\0');
  const ssize_t got =
      pread(descriptor_, text.data(), text.size(), end - static_cast<off_t>(text.size()));
  text.resize(std::max<ssize_t>(got, 0));
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) lines.push_back(line);
  }
  if (lines.size() > max_lines) lines.erase(lines.begin(), lines.end() - max_lines);
  return lines;
}

ChildProcess::ChildProcess(const std::vector<std::string>& command,
                           const std::vector<std::string>& environment, const ChildLog& log) {
  CheckInput(!command.empty() && !command.front().empty(), "the command is empty");
  Pipe to_child, from_child, failure;
  const std::vector<std::string> variables = EnvironmentWith(environment);
  const std::vector<char*> arguments = Pointers(command), entries = Pointers(variables);
  const Launch launch{arguments.data(), entries.data(),  to_child.ends[0], from_child.ends[1],
                      log.descriptor(), failure.ends[1], getpid()};
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error(fmt::format("cannot fork: {}", std::strerror(errno)));
  if (pid_ == 0) Become(launch);
  setpgid(pid_, pid_);  // in both processes, since either may run first
  failure.Close(1);
  if (const int error = StartError(failure.ends[0])) {
    ReapFor(pid_);
    throw InputError(fmt::format("cannot start '{}': {}; name a program of PATH, or its file",
                                 command.front(), std::strerror(error)));
  }
  input_ = to_child.Take(1);
  output_ = from_child.Take(0);
}

ChildProcess::~ChildProcess() {
  End(std::chrono::milliseconds(0));
  if (input_ >= 0) close(input_);
  if (output_ >= 0) close(output_);
}

bool ChildProcess::HasEnded() const {
  siginfo_t end = {};
  // WNOWAIT keeps the zombie, so that the number of the group cannot be used again yet.
  return waitid(P_PID, static_cast<id_t>(pid_), &end, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         end.si_pid == pid_;
}

std::string ChildProcess::End(std::chrono::milliseconds grace) {
  if (pid_ < 0) return "was stopped";
  const auto deadline = std::chrono::steady_clock::now() + grace;
  bool ended = HasEnded();
  while (!ended && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kCheckEvery);
    ended = HasEnded();
  }
  std::string how = "was stopped";
  if (ended) {
    siginfo_t end = {};
    waitid(P_PID, static_cast<id_t>(pid_), &end, WEXITED | WNOHANG | WNOWAIT);
    how = EndInWords(end);
  }
  kill(-pid_, SIGKILL);
  ReapFor(pid_);
  pid_ = -1;
  return how;
}

}  // namespace pickbed::scenes
