#include "perception/training/training_views.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

namespace pickbed::perception {
namespace {

constexpr size_t kTrainingSetsAhead = 1;  // each holds hundreds of megabytes

}  // namespace

struct TrainingViews::Impl {
  Impl(LabelledViewSource& source, TrainingViewsPlan plan)
      : source(source), plan(std::move(plan)) {}

  LabelledViewSource& source;
  const TrainingViewsPlan plan;

  std::mutex mutex;  // guards the queues and `failure`
  std::condition_variable changed;
  std::deque<HeldOutSet> held_out;
  std::deque<ClutterPairs> clutter_scenes;
  std::deque<VerifierTrainingSet> training_sets;
  std::exception_ptr failure;

  std::atomic<bool> stop = false;
  std::atomic<bool> skip_scenes = false;
  std::thread thread;  // last member, because it uses the others

  void Run();
  void MakeAll();
  ClutterPairs MakeClutterScene(int index);
  template <typename Item>
  void Hand(std::deque<Item>& to, Item item, size_t ahead);
  template <typename Item>
  std::optional<Item> Take(std::deque<Item>& from, Wait wait);
};

// Appends an item to a queue. Waits while the queue holds `ahead` items or more.
template <typename Item>
void TrainingViews::Impl::Hand(std::deque<Item>& to, Item item, size_t ahead) {
  std::unique_lock lock(mutex);
  changed.wait(lock, [&] { return stop || to.size() < ahead; });
  to.push_back(std::move(item));
  changed.notify_all();
}

template <typename Item>
std::optional<Item> TrainingViews::Impl::Take(std::deque<Item>& from, Wait wait) {
  std::unique_lock lock(mutex);
  changed.wait_for(lock, wait, [&] { return failure || !from.empty(); });
  if (from.empty()) {
    if (failure) std::rethrow_exception(failure);
    return std::nullopt;
  }
  std::optional<Item> item(std::move(from.front()));
  from.pop_front();
  changed.notify_all();
  return item;
}

ClutterPairs TrainingViews::Impl::MakeClutterScene(int index) {
  Rng rng = Rng::Derive(plan.seed, index, "training/pile");
  const std::vector<LabelledView> clutter_scene =
      source.ClutterScene({rng.Next(), plan.views_per_scene, plan.scene_objects[index]});
  ClutterPairs pairs(source.objects().size());
  AppendPositivePatches(source, clutter_scene, plan.forms, plan.positive_pairs, rng, pairs);
  return pairs;
}

void TrainingViews::Impl::MakeAll() {
  constexpr size_t kAll = SIZE_MAX;  // no limit, because the trainer keeps all pairs anyway
  const auto go_on = [this](double) { return !stop; };
  Hand(held_out, MakeHeldOut(source, plan.forms, plan.held_out, plan.seed, go_on), kAll);
  const int count = static_cast<int>(plan.scene_objects.size());
  for (int i = 0; i < count && !stop && !skip_scenes; ++i)
    Hand(clutter_scenes, MakeClutterScene(i), kAll);
  for (size_t i = 0; i < plan.verifiers.size(); ++i) {
    if (stop) return;
    const ObjectId object = plan.verifiers[i];
    VerifierTrainingOptions options = plan.verifier;
    if (!plan.deadlines.empty()) options.deadlines = plan.deadlines[i];
    Hand(training_sets, MakeVerifierTrainingSet(source, object, plan.forms[object], options, go_on),
         kTrainingSetsAhead);
  }
}

void TrainingViews::Impl::Run() {
  try {
    MakeAll();
  } catch (...) {
    const std::lock_guard lock(mutex);
    failure = std::current_exception();
    changed.notify_all();
  }
}

TrainingViews::TrainingViews(LabelledViewSource& source, TrainingViewsPlan plan)
    : impl_(std::make_unique<Impl>(source, std::move(plan))) {
  impl_->thread = std::thread([this] { impl_->Run(); });
}

TrainingViews::~TrainingViews() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stop = true;
    impl_->changed.notify_all();
  }
  impl_->thread.join();
}

std::optional<HeldOutSet> TrainingViews::TakeHeldOut(Wait wait) {
  return impl_->Take(impl_->held_out, wait);
}
std::optional<ClutterPairs> TrainingViews::TakeScene(Wait wait) {
  return impl_->Take(impl_->clutter_scenes, wait);
}
std::optional<VerifierTrainingSet> TrainingViews::TakeTrainingSet(Wait wait) {
  return impl_->Take(impl_->training_sets, wait);
}

void TrainingViews::SkipScenes() { impl_->skip_scenes = true; }

}  // namespace pickbed::perception
