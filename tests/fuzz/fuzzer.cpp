// A fuzz target for libFuzzer.
//
//   pickbed_fuzzer --target=NAME [CORPUS...] [-OPTION=VALUE...]   runs the target
//   pickbed_fuzzer --list                                        prints the names of all targets
//   pickbed_fuzzer --target=NAME --seeds=FOLDER                   writes the seeds of the target
//
// A finding is a crash, undefined behaviour, a hang, too much memory, an exception that is no
// refusal, and a refusal that does not name the file or has several lines.

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/fuzz/campaign.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

const FuzzTarget* chosen = nullptr;

void WriteSeeds(const std::filesystem::path& folder) {
  MakeFolder(folder);
  int number = 0;
  for (const std::string& seed : chosen->seeds()) {
    WriteFileAtomically(folder / fmt::format("seed_{:04}", number++), seed);
  }
}

void Initialize(int argc, char** argv) {
  constexpr std::string_view kTarget = "--target=", kSeeds = "--seeds=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--list") {
      for (const FuzzTarget& target : FuzzTargets()) fmt::print("{}\n", target.name);
      std::exit(0);
    }
    if (argument.starts_with(kTarget)) {
      chosen = &FindFuzzTarget(std::string(argument.substr(kTarget.size())));
    }
    if (argument.starts_with(kSeeds) && chosen != nullptr) {
      WriteSeeds(argument.substr(kSeeds.size()));
      std::exit(0);
    }
  }
  CheckInput(chosen != nullptr, "name a target (--target=NAME); --list prints them");
}

// Folder of the inputs and of the cache, which a long run would fill. It is made anew now and then.
const std::filesystem::path& Folder() {
  constexpr int kRunsOfAFolder = 10000;
  static int runs = 0;
  static std::unique_ptr<TemporaryFolder> folder;
  if (runs++ % kRunsOfAFolder == 0) {
    folder = std::make_unique<TemporaryFolder>();
    setenv("XDG_CACHE_HOME", folder->path().c_str(), 1);
  }
  return folder->path();
}

void RunInput(const std::string& bytes) {
  const FuzzCase result = RunFuzzCaseHere(*chosen, Folder(), bytes);
  if (result.result == FuzzResult::kAccepted || result.result == FuzzResult::kRefused) return;
  fmt::print(stderr, "{}: {}: {}\n", chosen->name, FuzzResultName(result.result), result.message);
  std::abort();
}

}  // namespace
}  // namespace pickbed::tests

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  try {
    pickbed::tests::Initialize(*argc, *argv);
  } catch (const pickbed::scenes::InputError& error) {
    fmt::print(stderr, "pickbed_fuzzer: {}\n", error.what());
    std::exit(1);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  pickbed::tests::RunInput(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
