#pragma once

// Frames of a depth camera with simulated damage, and the stages that `pickbed estimate` runs on
// them: files, checks of the frame, cloud, background, descriptor, ICP, verifier and pictures.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scenes/base/random.h"
#include "scenes/camera/rgbd_frame.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

struct NamedFrame {
  std::string name;
  RgbdFrame frame;
};

// Returns the real frames in a folder of test data (bop_*/test and mosd); without any, one drawn
// frame. The list has at most `limit` frames of different cameras or scenes.
std::vector<NamedFrame> FramesToDamage(const std::filesystem::path& test_data, int limit);

// Cuts a random rectangle out of a frame and damages it in one to three ways: holes, NaN and
// infinity, saturated, constant, negative and tiny readings, no reading at all, missing bands,
// noise, coarse steps, shifted rows, and color that is missing, black or saturated. Returns the
// frame, with the names of the damages.
NamedFrame DamagedFrame(const NamedFrame& given, Rng& rng);

// The estimators of some frames. They are made once, because codebooks take seconds.
class DamagedFrameRun {
 public:
  explicit DamagedFrameRun(std::vector<NamedFrame> frames);
  ~DamagedFrameRun();

  // What a frame led to.
  struct Outcome {
    std::string what;     // the frame, its damages and its files
    std::string refusal;  // the message of the InputError; empty if poses were estimated
    int poses = 0;
  };

  // Writes one damaged frame to files, of which some are cut, and estimates poses in it, as
  // `estimate IMAGE`. Throws std::runtime_error for a pose or a score that is not one, and for a
  // refusal that does not name the file.
  Outcome RunImage(uint64_t seed, uint64_t number);

 private:
  struct Estimators;
  std::vector<NamedFrame> frames_;
  std::unique_ptr<Estimators> estimators_;
};

}  // namespace pickbed::tests
