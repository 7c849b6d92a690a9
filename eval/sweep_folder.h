#pragma once

// Whose sweep a results folder is.

#include <filesystem>
#include <string>

namespace pickbed {

// Throws InputError where `out` holds the sweep.yaml of other settings than those of `yaml`. How
// Slurm is to run a sweep is none of them.
void RequireNoOtherSweep(const std::filesystem::path& out, const std::string& yaml);

}  // namespace pickbed
