#pragma once

// Distributes independent work items over processes. Processes are used instead of threads, so that
// a GL context, Bullet and libtorch never share a heap, and a crash loses only one item.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

// Work items and the functions that process them.
struct WorkerPlan {
  std::vector<int> items;
  int jobs = 1;  // at least 1

  // Sends lines from a worker to the calling process.
  struct Say {
    std::function<void(std::string_view line)> message;  // to `on_message`: progress
    std::function<void(std::string_view line)> warning;  // to `on_warning`
    void operator()(std::string_view line) const { message(line); }
  };
  // Runs once in every worker: prepares shared data and returns the function for one item. The
  // result of that function goes to `on_done`. What it holds is destroyed after the last item.
  using DoItem = std::function<std::string(int item)>;
  std::function<DoItem(const Say& say)> start;

  // Number of retries of an item whose worker threw or crashed, before it is lost. As many workers
  // may be killed while they start.
  int retries = 0;
  // Items of one group share expensive data. A worker continues with the group of its last item,
  // then with a group that no other worker uses. Without `group`, items are processed in order.
  std::function<int(int item)> group;
  // Checked before an item is assigned; true skips the item.
  std::function<bool(int item)> needless;

  // Callbacks in the calling process, one at a time.
  std::function<void(int item, const std::string& reply)> on_done;
  std::function<void(int item, const std::string& why)> on_lost;
  std::function<void(const std::string& line)> on_message;
  std::function<void(const std::string& line)> on_warning;
  std::function<bool()> stop;  // true ends all workers at once
};

// Item that failed, with the reason.
struct LostItem {
  int item = 0;
  std::string why;
};
// Result of RunInWorkers.
struct WorkReport {
  bool stopped = false;
  std::vector<LostItem> lost;  // items whose worker threw or crashed; other items are not affected
};

// Returns whether a reason of a lost item is a lack of memory, or a kill that suggests one. Such a
// loss is no fault of the code.
bool LacksMemory(std::string_view why);

// Executes all items in forked workers. The caller must not have used GL, libtorch or SQLite, which
// do not survive a fork. Workers start concurrently; a missing cache file is computed by one of
// them (scenes/base/cache_lock.h). An InputError in a worker ends the run and is thrown here. So
// does one that another process killed while it started. Any other failure in `start` is thrown as
// std::runtime_error.
WorkReport RunInWorkers(const WorkerPlan& plan);

}  // namespace pickbed::eval
