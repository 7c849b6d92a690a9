#include "eval/runtime/process.h"

#include <fcntl.h>
#include <malloc.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <sstream>
#include <stdexcept>
#include <string>

namespace pickbed::eval {
namespace {

volatile sig_atomic_t g_interrupted = 0;

void ExitNow(int) {
  constexpr char kMessage[] = "pickbed: interrupted\n";
  // write() is async-signal-safe; printing is not.
  if (write(STDERR_FILENO, kMessage, sizeof(kMessage) - 1) < 0) _exit(kExitInterrupted);
  _exit(kExitInterrupted);
}

void SetFlag(int signal) {
  if (g_interrupted) ExitNow(signal);
  g_interrupted = 1;
}

void Handle(void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  // No SA_RESTART: a signal must interrupt a poll() that waits for workers.
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

void ExitOnInterrupt() { Handle(ExitNow); }
void CatchInterrupts() { Handle(SetFlag); }
bool Interrupted() { return g_interrupted != 0; }

// Weak symbols: null if the process has no OpenBLAS or OpenMP.
extern "C" {
void openblas_set_num_threads(int threads) __attribute__((weak));
void omp_set_num_threads(int threads) __attribute__((weak));
}

void UseOneThread() {
  for (const char* name :
       {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"}) {
    setenv(name, "1", 1);
  }
  // llvmpipe is fastest without raster threads if every worker has its own context.
  setenv("LP_NUM_THREADS", "0", 1);
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  if (omp_set_num_threads != nullptr) omp_set_num_threads(1);
}

namespace {

// Value of a line like "VmHWM:   1234 kB" in /proc/self/status; 0 without such a line.
size_t StatusBytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    size_t kilobytes = 0;
    if (word == key && status >> kilobytes) return 1024 * kilobytes;
  }
  return 0;
}

}  // namespace

void ReleaseFreedMemory() {
  constexpr size_t kKeptBytes = 0;
  malloc_trim(kKeptBytes);
}

size_t ResetPeakMemory() {
  constexpr const char* kForgetPeak = "5";  // proc(5), clear_refs
  std::ofstream("/proc/self/clear_refs") << kForgetPeak;
  return StatusBytes("VmRSS:");
}

size_t PeakMemory() { return StatusBytes("VmHWM:"); }

namespace {

constexpr int kCannotStart = 127;

[[noreturn]] void Become(const std::vector<std::string>& arguments, int output) {
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) {
    pointers.push_back(const_cast<char*>(argument.c_str()));
  }
  pointers.push_back(nullptr);
  execvp(pointers[0], pointers.data());
  _exit(kCannotStart);
}

std::string ReadAllOf(int file) {
  std::string text;
  std::array<char, 4096> buffer;
  while (true) {
    const ssize_t got = read(file, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(buffer.data(), got);
  }
}

}  // namespace

ProgramOutput RunProgram(const std::vector<std::string>& arguments) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) Become(arguments, ends[1]);
  close(ends[1]);
  ProgramOutput output;
  output.text = ReadAllOf(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  output.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return output;
}

bool HasProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "/usr/bin:/bin" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((folder + "/" + name).c_str(), X_OK) == 0) return true;
  }
  return false;
}

}  // namespace pickbed::eval
