#pragma once

// Independent items of work over several processes. A process each, not a thread, since a GL
// context, Bullet and libtorch then never share a heap, and since a crash loses one item only.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace pickbed {

struct WorkerPlan {
  std::vector<int> items;
  int jobs = 1;  // >= 1

  // Runs once in every worker: makes what all its items need and returns what to do with one item.
  // What that returns is handed to `on_done`. `say` carries a line to `on_message`.
  using Say = std::function<void(std::string_view line)>;
  using DoItem = std::function<std::string(int item)>;
  std::function<DoItem(const Say& say)> start;

  // An item whose worker threw or crashed is tried again so many times before it is lost.
  int retries = 0;
  // Items of one group share what is costly to make: a worker goes on with the group of its last
  // item while there are some, then with one that no other worker is at. Without: in their order.
  std::function<int(int item)> group;
  // Asked before an item is given to a worker: one that is needed no more is left out.
  std::function<bool(int item)> needless;

  // In the calling process, one at a time.
  std::function<void(int item, const std::string& reply)> on_done;
  std::function<void(int item, const std::string& why)> on_lost;
  std::function<void(const std::string& line)> on_message;
  std::function<bool()> stop;  // true ends all workers at once
};

struct LostItem {
  int item = 0;
  std::string why;
};
struct WorkReport {
  bool stopped = false;
  std::vector<LostItem> lost;  // items whose worker threw or crashed; the others went on
};

// Forks. The caller must not have touched GL, libtorch or SQLite, which do not survive a fork. All
// workers start at once; what a cache lacks one makes while the others wait, scenes/cache_lock.h.
// An InputError in a worker ends the run and is thrown here, and so is any failure of `start`
// (std::runtime_error).
WorkReport RunInWorkers(const WorkerPlan& plan);

}  // namespace pickbed
