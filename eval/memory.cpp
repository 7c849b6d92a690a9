#include "eval/memory.h"

#include <malloc.h>

#include <fstream>
#include <string>

namespace pickbed {
namespace {

// A line "VmHWM:   1234 kB" of /proc/self/status; 0 where there is none.
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

}  // namespace pickbed
