#pragma once

// Worker side of a sweep: runs trials, writes them to the store, and sends one line per trial to
// the calling process.

#include <filesystem>
#include <string>

#include "eval/sweep/sweep.h"

namespace pickbed::eval {

// Opens the store in `folder` for a worker. Returns a function that runs one trial and returns its
// reply line. `sweep` and `options` must outlive it.
WorkerPlan::DoItem StartWorker(const Sweep& sweep, const SweepOptions& options,
                               const StoreHead& head, const std::filesystem::path& folder,
                               const WorkerPlan::Say& say);

// Parses a reply line: returns the counts of executed grasps and successes, and adds the times to
// `seconds`.
Cluster TakeReply(const std::string& reply, StageSeconds& seconds);

}  // namespace pickbed::eval
