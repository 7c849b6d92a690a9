#include <gtest/gtest.h>

#include <sstream>

#include "eval/draw/grasp_sheet.h"
#include "eval/export/grasps_csv.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

GraspCandidate Candidate(double x_m, double robust) {
  GraspCandidate candidate;
  candidate.X_OG = Translation({x_m, 0.02, -0.03});
  candidate.robust = robust;
  return candidate;
}

TEST(GraspsCsv, NumbersRoundTripExactly) {
  GraspCandidate candidate = Candidate(0.1 / 3, 0.75);
  candidate.X_OG.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  candidate.width_m = 0.05;
  candidate.depth_m = 0.012;
  candidate.quality = 1.0 / 7;
  candidate.epsilon = 2.5;
  std::istringstream lines(GraspsCsv({candidate, Candidate(1, 0)}));
  std::string header, line, cell;
  std::getline(lines, header);
  std::getline(lines, line);
  std::vector<double> numbers;
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) {
    numbers.push_back(std::stod(cell));
  }
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), 16);
  ASSERT_EQ(numbers.size(), 17u);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(numbers.data());
  EXPECT_EQ(R, candidate.X_OG.linear());
  EXPECT_EQ(Eigen::Vector3d(numbers[9], numbers[10], numbers[11]), candidate.X_OG.translation());
  EXPECT_EQ(std::vector<double>(numbers.begin() + 12, numbers.end()),
            (std::vector<double>{0.05, 0.012, 1.0 / 7, 2.5, 0.75}));
}

TEST(GraspsToDraw, MostRobustGraspOfEachPlaceComesFirst) {
  const std::vector<GraspCandidate> candidates{Candidate(0, 0.5), Candidate(0.001, 0.9),
                                               Candidate(0.05, 0.7), Candidate(0.051, 0.6)};
  EXPECT_EQ(GraspsToDraw(candidates, 10, 0.1), (std::vector<int>{1, 2}));
  EXPECT_EQ(GraspsToDraw(candidates, 1, 0.1), (std::vector<int>{1}));
}

}  // namespace
}  // namespace pickbed::tests
