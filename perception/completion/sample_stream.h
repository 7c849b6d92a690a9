#pragma once

// Groups of training samples, made ahead by threads while the network trains.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "perception/completion/training_sample.h"

namespace pickbed::perception {

class SampleStream {
 public:
  using Group = std::vector<CompletionSample>;
  // `make` returns group 0, 1, ...; threads call it from `first` on. They stay at most `ahead`
  // groups ahead of the last one that was asked for.
  SampleStream(std::function<Group(int64_t)> make, int64_t first, int ahead, int threads);
  ~SampleStream();
  SampleStream(const SampleStream&) = delete;
  SampleStream& operator=(const SampleStream&) = delete;

  // Waits until group `last` exists and forgets the groups before `first`. Both may not decrease.
  // Rethrows what `make` threw.
  void Advance(int64_t first, int64_t last);
  // Returns a group between the first and the last one of Advance().
  const Group& At(int64_t group) const;

 private:
  void Work();

  std::function<Group(int64_t)> make_;
  int ahead_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::unique_ptr<Group>> groups_;  // from first_; null = not made yet
  int64_t first_, next_, wanted_;
  bool ends_ = false;
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace pickbed::perception
