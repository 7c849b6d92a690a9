#pragma once

// The side of a sweep that runs in its workers: trials are done, written to the store, and told to
// the calling process in a line each.

#include <filesystem>
#include <string>

#include "eval/sweep.h"

namespace pickbed {

std::filesystem::path PicturesOf(const std::filesystem::path& out, int trial);

// Opens the store in `folder` for a worker; what it returns does one trial and gives its line.
// `sweep` and `options` must outlive it.
WorkerPlan::DoItem StartWorker(const Sweep& sweep, const SweepOptions& options,
                               const StoreHead& head, const std::filesystem::path& folder,
                               const WorkerPlan::Say& say);

// Successes of attempts, of such a line; the seconds in it are added.
Cluster TakeReply(const std::string& reply, StageSeconds& seconds);

}  // namespace pickbed
