#include "tests/fuzz/campaign.h"

#include <fmt/format.h>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/isolated_call.h"
#include "scenes/plugin/message.h"
#include "tests/fuzz/mutator.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

constexpr char kAccepted = 'a', kRefused = 'r', kOther = 'o';

// Returns how the target ended, and the message of its error.
std::string Answer(const FuzzTarget& target, const std::filesystem::path& folder,
                   const std::string& bytes) {
  try {
    target.run(folder, bytes);
    return {kAccepted};
  } catch (const InputError& error) {
    return kRefused + std::string(error.what());
  } catch (const MessageError& error) {
    return kRefused + std::string(error.what());
  } catch (const std::exception& error) {
    return kOther + std::string(error.what());
  }
}

FuzzResult ResultOf(const FuzzTarget& target, const std::filesystem::path& folder,
                    const std::string& answer) {
  if (answer[0] == kAccepted) return FuzzResult::kAccepted;
  if (answer[0] == kOther) return FuzzResult::kOtherError;
  if (answer.find('\n') != std::string::npos) return FuzzResult::kSeveralLines;
  const bool named = !target.reads_file || answer.find(folder.string()) != std::string::npos;
  return named ? FuzzResult::kRefused : FuzzResult::kNameless;
}

}  // namespace

const char* FuzzResultName(FuzzResult result) {
  constexpr const char* kNames[kFuzzResults] = {"accepted",      "refused",     "without file name",
                                                "several lines", "other error", "crash",
                                                "hang",          "memory"};
  return kNames[static_cast<int>(result)];
}

FuzzCase RunFuzzCaseHere(const FuzzTarget& target, const std::filesystem::path& folder,
                         const std::string& bytes) {
  const std::string answer = Answer(target, folder, bytes);
  return {ResultOf(target, folder, answer), answer.substr(1)};
}

FuzzCase RunFuzzCase(const FuzzTarget& target, const std::filesystem::path& folder,
                     const std::string& bytes) {
  IsolationLimits limits;
  limits.seconds = 30;
  try {
    const std::string answer = CallIsolated([&] { return Answer(target, folder, bytes); }, limits);
    return {ResultOf(target, folder, answer), answer.substr(1)};
  } catch (const IsolationError& error) {
    const std::string what = error.what();
    const FuzzResult result = what.find("takes more than") != std::string::npos ? FuzzResult::kHang
                              : what.find("memory") != std::string::npos ? FuzzResult::kMemory
                                                                         : FuzzResult::kCrash;
    return {result, what};
  }
}

std::array<int, kFuzzResults> RunCampaign(
    const FuzzTarget& target, int cases, uint64_t seed,
    const std::function<void(int, const FuzzCase&, const std::string&)>& on_case) {
  const TemporaryFolder temporary;
  const std::vector<std::string> seeds = target.seeds();
  std::array<int, kFuzzResults> counts{};
  for (int number = 0; number < cases; ++number) {
    Rng rng = Rng::Derive(seed, static_cast<uint64_t>(number), target.name);
    const std::string bytes = Mutated(seeds, rng);
    const FuzzCase result = RunFuzzCase(target, temporary.path(), bytes);
    ++counts[static_cast<int>(result.result)];
    if (on_case) on_case(number, result, bytes);
  }
  return counts;
}

}  // namespace pickbed::tests
