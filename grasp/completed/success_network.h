#pragma once

// Network that estimates the chance that a jaw's grasp of an unknown object succeeds, from measures
// of the grasp and from what surrounds the hand. It is trained on grasps that were executed in
// simulated bins (`pickbed train grasps`).

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "grasp/completed/hand_surroundings.h"
#include "grasp/completed/success_chance.h"

namespace pickbed::grasp {

// Number of inputs: measures of the grasp, then HandSurroundings.
inline constexpr int kGraspMeasureInputs = 9;
inline constexpr int kSuccessInputs = kGraspMeasureInputs + kSurroundingsValues;

// Returns the inputs of a grasp, scaled to about 1.
// - opening_m: distance between the open fingers; tilt_rad: angle of the approach from straight
//   down; surroundings: kSurroundingsValues values of HandSurroundings
std::vector<float> SuccessInputs(const GraspMeasures& measures, double opening_m, double tilt_rad,
                                 std::span<const float> surroundings);

// Layer of a perceptron: weights * x + bias.
struct PerceptronLayer {
  Eigen::MatrixXf weights;  // outputs x inputs
  Eigen::VectorXf bias;
};

// Perceptron with rectified hidden layers. Input i is (value - mean) / scale, clamped to
// [-kMaxInput, kMaxInput]. Its sums are computed by Eigen, which gives the same bits on every CPU.
struct SuccessNetwork {
  static constexpr float kMaxInput = 4;
  std::string training;                 // settings and statistics of the training
  Eigen::VectorXf mean, scale;          // kSuccessInputs values
  std::vector<PerceptronLayer> layers;  // the last has one output, the log odds

  // Returns the chance of success, 0..1, for the values of SuccessInputs().
  double Chance(std::span<const float> inputs) const;
};

// Writes the file atomically. Equal networks give equal bytes.
void SaveSuccessNetwork(const std::filesystem::path& file, const SuccessNetwork& network);

// Throws InputError that names the file if it is missing, cut short, damaged, of another kind or of
// a newer version.
SuccessNetwork LoadSuccessNetwork(const std::filesystem::path& file);

// `name` is a file or a name in assets/models, see TrainedFile(). Returns null for kNoSuccessModel.
// Throws as LoadSuccessNetwork().
std::shared_ptr<const SuccessNetwork> SuccessNetworkNamed(const std::string& name);

}  // namespace pickbed::grasp
