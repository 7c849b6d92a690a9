#include "perception/training_schedule.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace pickbed {
namespace {

// Of the piles, that the first step waits for.
constexpr double kFirstShare = 0.08;

int Rounded(double value) { return static_cast<int>(std::lround(value)); }

}  // namespace

// Each turn all gain their weight and the richest pays for the turn (smooth weighted round-robin).
std::vector<int> TakeTurns(const std::vector<double>& weights, int count) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (weights.empty() || *std::min_element(weights.begin(), weights.end()) <= 0) {
    throw std::logic_error("taking turns needs weights above 0");
  }
  // Rounding of sums must not decide who is richest.
  constexpr double kTie = 1e-9;
  std::vector<double> credit(weights.size(), 0);
  std::vector<int> turns(count);
  for (int& turn : turns) {
    for (size_t i = 0; i < weights.size(); ++i) credit[i] += weights[i];
    turn = 0;
    for (size_t i = 1; i < weights.size(); ++i) {
      if (credit[i] > credit[turn] + kTie * total) turn = static_cast<int>(i);
    }
    credit[turn] -= total;
  }
  return turns;
}

TrainingSchedule::TrainingSchedule(const std::vector<double>& weights,
                                   const TrainingOptions& options)
    : held_out_(options.held_out), views_share_(options.views_share) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  iterations_ = Rounded(options.iterations * total);
  measure_every_ = std::max(1, Rounded(options.held_out.every * total));
  main_parts_ = TakeTurns(weights, iterations_);
  // Each part is in one pile at least, however low its weight.
  std::vector<double> piles;
  for (const double weight : weights) piles.push_back(std::max(1, Rounded(options.piles * weight)));
  pile_parts_ = TakeTurns(piles, Rounded(std::accumulate(piles.begin(), piles.end(), 0.0)));
}

void TrainingSchedule::Watch(const std::vector<HeldOutRecall>& history) {
  const int index = PlateauOf(history, held_out_);
  plateau_iteration_ = index < 0 ? -1 : history[index].iteration;
}

double TrainingSchedule::Share(int iteration) const {
  if (iterations_ == 0) return 1;
  const double share = static_cast<double>(iteration) / iterations_;
  if (plateau_iteration_ < 0 || iteration <= plateau_iteration_) return share;
  const double flat = static_cast<double>(plateau_iteration_) / iterations_;
  const int cooling = std::max(1, Rounded(held_out_.cooling * iterations_));
  const int left = std::min(cooling, iterations_ - plateau_iteration_);
  if (left <= 0) return share;
  return flat + (1 - flat) * (iteration - plateau_iteration_) / left;
}

int TrainingSchedule::FirstPiles() const {
  return std::max(1, static_cast<int>(std::ceil(kFirstShare * piles())));
}

int TrainingSchedule::WantedPiles(double share) const {
  if (plateau_iteration_ >= 0) {
    share = std::min(share, static_cast<double>(plateau_iteration_) / iterations_);
  }
  const int wanted = static_cast<int>(std::ceil(piles() * share / views_share_));
  return std::clamp(wanted, FirstPiles(), piles());
}

}  // namespace pickbed
