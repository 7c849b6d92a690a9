#pragma once

// Runs mutated inputs, each in a process of its own, and classifies what happens.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "tests/fuzz/targets.h"

namespace pickbed::tests {

enum class FuzzResult {
  kAccepted,
  kRefused,   // InputError or MessageError
  kNameless,  // a refusal that does not name the file
  kSeveralLines,
  kOtherError,  // another exception; the program would exit with status 2
  kCrash,
  kHang,    // over the time limit
  kMemory,  // over the memory limit
};
inline constexpr int kFuzzResults = 8;
const char* FuzzResultName(FuzzResult result);

struct FuzzCase {
  FuzzResult result = FuzzResult::kAccepted;
  std::string message;  // of the error
};

// Runs one input in this process.
FuzzCase RunFuzzCaseHere(const FuzzTarget& target, const std::filesystem::path& folder,
                         const std::string& bytes);

// Runs one input in a child process with limits: 30 s and 4 GB.
FuzzCase RunFuzzCase(const FuzzTarget& target, const std::filesystem::path& folder,
                     const std::string& bytes);

// Runs `cases` mutations of the seeds of a target. The same seed gives the same inputs. Returns the
// number of each result. `on_case` receives each case with its input.
std::array<int, kFuzzResults> RunCampaign(
    const FuzzTarget& target, int cases, uint64_t seed,
    const std::function<void(int number, const FuzzCase& result, const std::string& bytes)>&
        on_case = {});

}  // namespace pickbed::tests
