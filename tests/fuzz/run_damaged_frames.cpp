// Estimates poses in damaged frames, and prints how each ended.
//
//   damaged_frames COUNT SEED [FIRST]
//
// FIRST is the number of the first frame, to repeat one. The number of a frame is printed before it
// is processed, so that the last line names the one that crashes. Exit status 1: a result is wrong.

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "tests/fuzz/damaged_frames.h"

namespace pickbed::tests {
namespace {

int Run(int count, uint64_t seed, uint64_t first) {
  constexpr int kFrames = 20;
  DamagedFrameRun run(FramesToDamage(PICKBED_TEST_DATA, kFrames));
  int frames = 0, refused = 0, with_poses = 0, wrong = 0;
  for (uint64_t number = first; frames < count; ++number) {
    fmt::print("{}: ", number);
    std::fflush(stdout);
    try {
      const DamagedFrameRun::Outcome outcome = run.RunImage(seed, number);
      fmt::print("{}: {} poses {}\n", outcome.what, outcome.poses, outcome.refusal);
      refused += !outcome.refusal.empty();
      with_poses += outcome.poses > 0;
    } catch (const std::exception& error) {
      fmt::print("WRONG: {}\n", error.what());
      ++wrong;
    }
    ++frames;
  }
  fmt::print("{} frames: {} with poses, {} with a refusal, {} wrong\n", frames, with_poses, refused,
             wrong);
  return wrong > 0;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    fmt::print(stderr, "usage: damaged_frames COUNT SEED [FIRST]\n");
    return 1;
  }
  return pickbed::tests::Run(std::atoi(argv[1]), std::strtoull(argv[2], nullptr, 10),
                             argc == 4 ? std::strtoull(argv[3], nullptr, 10) : 0);
}
