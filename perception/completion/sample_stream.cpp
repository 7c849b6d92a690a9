#include "perception/completion/sample_stream.h"

#include <utility>

namespace pickbed::perception {

SampleStream::SampleStream(std::function<Group(int64_t)> make, int64_t first, int ahead,
                           int threads)
    : make_(std::move(make)), ahead_(ahead), first_(first), next_(first), wanted_(first) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
}

SampleStream::~SampleStream() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void SampleStream::Work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return ends_ || next_ <= wanted_ + ahead_; });
    if (ends_) return;
    const int64_t group = next_++;
    groups_.emplace_back();
    lock.unlock();
    auto made = std::make_unique<Group>();
    std::exception_ptr failure;
    try {
      *made = make_(group);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure) {
      failure_ = failure;
      ends_ = true;
    } else if (group >= first_) {
      groups_[group - first_] = std::move(made);
    }
    changed_.notify_all();
    if (ends_) return;
  }
}

void SampleStream::Advance(int64_t first, int64_t last) {
  std::unique_lock lock(mutex_);
  wanted_ = std::max(wanted_, last);
  changed_.notify_all();
  changed_.wait(lock, [&] {
    if (failure_) return true;
    if (next_ <= last) return false;
    for (int64_t group = first; group <= last; ++group) {
      if (!groups_[group - first_]) return false;
    }
    return true;
  });
  if (failure_) std::rethrow_exception(failure_);
  while (first_ < first) {
    groups_.pop_front();
    ++first_;
  }
}

const SampleStream::Group& SampleStream::At(int64_t group) const {
  const std::lock_guard lock(mutex_);
  return *groups_[group - first_];
}

}  // namespace pickbed::perception
