// Runs mutated inputs of all formats, and keeps the ones that fail.
//
//   fuzz_campaign CASES SEED OUT [TARGET...]
//
// CASES is the number of inputs of each target. OUT/TARGET gets the inputs that crash, hang, take
// too much memory, or end in an error that does not name the file. OUT/accepted gets every
// hundredth input that is accepted, to be looked at. OUT/seeds gets the contents that are mutated,
// to be compared with them.

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <map>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/fuzz/campaign.h"

namespace pickbed::tests {
namespace {

void RunTarget(const FuzzTarget& target, int cases, uint64_t seed, const std::filesystem::path& out,
               std::array<int, kFuzzResults>& sum) {
  constexpr int kKeepEvery = 100;
  int seed_number = 0;
  for (const std::string& content : target.seeds()) {
    MakeFolder(out / "seeds");
    WriteFileAtomically(out / "seeds" / fmt::format("{}_{:03d}", target.name, seed_number++),
                        content);
  }
  const auto keep = [&](int number, const FuzzCase& result, const std::string& bytes) {
    const bool fine =
        result.result == FuzzResult::kAccepted || result.result == FuzzResult::kRefused;
    const bool sample = result.result == FuzzResult::kAccepted && number % kKeepEvery == 0;
    if (fine && !sample) return;
    const std::filesystem::path folder = out / (fine ? "accepted" : target.name);
    MakeFolder(folder);
    WriteFileAtomically(folder / fmt::format("{}_{:06d}", target.name, number), bytes);
    if (!fine) {
      fmt::print("{} {}: {}: {}\n", target.name, number, FuzzResultName(result.result),
                 result.message);
    }
  };
  const std::array<int, kFuzzResults> counts = RunCampaign(target, cases, seed, keep);
  std::string line = fmt::format("{:<18}", target.name);
  for (int i = 0; i < kFuzzResults; ++i) {
    sum[i] += counts[i];
    line += fmt::format(" {} {};", counts[i], FuzzResultName(static_cast<FuzzResult>(i)));
  }
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

int Run(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: fuzz_campaign CASES SEED OUT [TARGET...]\n");
    return 1;
  }
  const int cases = std::atoi(argv[1]);
  const uint64_t seed = std::strtoull(argv[2], nullptr, 10);
  std::array<int, kFuzzResults> sum{};
  if (argc == 4) {
    for (const FuzzTarget& target : FuzzTargets()) RunTarget(target, cases, seed, argv[3], sum);
  }
  for (int i = 4; i < argc; ++i) RunTarget(FindFuzzTarget(argv[i]), cases, seed, argv[3], sum);
  for (int i = 0; i < kFuzzResults; ++i) {
    fmt::print("{:<18} {}\n", FuzzResultName(static_cast<FuzzResult>(i)), sum[i]);
  }
  const auto fine = [](int i) { return i <= static_cast<int>(FuzzResult::kRefused); };
  for (int i = 0; i < kFuzzResults; ++i) {
    if (!fine(i) && sum[i] > 0) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  try {
    return pickbed::tests::Run(argc, argv);
  } catch (const pickbed::scenes::InputError& error) {
    fmt::print(stderr, "fuzz_campaign: {}\n", error.what());
    return 1;
  }
}
