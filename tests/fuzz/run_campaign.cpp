// Runs mutated inputs of all formats, and keeps the ones that fail.
//
//   fuzz_campaign CASES SEED OUT [--keep-every N] [TARGET...]
//
// CASES is the number of inputs of each target. OUT/TARGET gets the inputs that crash, hang, take
// too much memory, or end in an error that does not name the file. OUT/accepted gets the accepted
// ones among every N inputs (default: 100), to be looked at. OUT/seeds gets the contents that are
// mutated, to be compared with them.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/fuzz/campaign.h"

namespace pickbed::tests {
namespace {

struct CampaignOptions {
  int cases = 0;
  uint64_t seed = 0;
  std::filesystem::path out;
  int keep_every = 100;
};

void RunTarget(const FuzzTarget& target, const CampaignOptions& options,
               std::array<int, kFuzzResults>& sum) {
  const std::filesystem::path& out = options.out;
  int seed_number = 0;
  for (const std::string& content : target.seeds()) {
    MakeFolder(out / "seeds");
    WriteFileAtomically(out / "seeds" / fmt::format("{}_{:03d}", target.name, seed_number++),
                        content);
  }
  const auto keep = [&](int number, const FuzzCase& result, const std::string& bytes) {
    const bool fine =
        result.result == FuzzResult::kAccepted || result.result == FuzzResult::kRefused;
    const bool sample = result.result == FuzzResult::kAccepted && number % options.keep_every == 0;
    if (fine && !sample) return;
    const std::filesystem::path folder = out / (fine ? "accepted" : target.name);
    MakeFolder(folder);
    WriteFileAtomically(folder / fmt::format("{}_{:06d}", target.name, number), bytes);
    if (!fine) {
      fmt::print("{} {}: {}: {}\n", target.name, number, FuzzResultName(result.result),
                 result.message);
    }
  };
  const std::array<int, kFuzzResults> counts =
      RunCampaign(target, options.cases, options.seed, keep);
  std::string line = fmt::format("{:<18}", target.name);
  for (int i = 0; i < kFuzzResults; ++i) {
    sum[i] += counts[i];
    line += fmt::format(" {} {};", counts[i], FuzzResultName(static_cast<FuzzResult>(i)));
  }
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

int Run(int argc, char** argv) {
  CampaignOptions options;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--keep-every" && i + 1 < argc) {
      options.keep_every = std::max(1, std::atoi(argv[++i]));
    } else {
      words.push_back(word);
    }
  }
  if (words.size() < 3) {
    fmt::print(stderr, "usage: fuzz_campaign CASES SEED OUT [--keep-every N] [TARGET...]\n");
    return 1;
  }
  options.cases = std::atoi(words[0].c_str());
  options.seed = std::strtoull(words[1].c_str(), nullptr, 10);
  options.out = words[2];
  std::array<int, kFuzzResults> sum{};
  if (words.size() == 3) {
    for (const FuzzTarget& target : FuzzTargets()) RunTarget(target, options, sum);
  }
  for (size_t i = 3; i < words.size(); ++i) RunTarget(FindFuzzTarget(words[i]), options, sum);
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
