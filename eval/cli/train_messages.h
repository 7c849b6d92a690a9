#pragma once

// Messages of trainings that were stopped, and that are resumed.

#include <filesystem>
#include <string>

#include "eval/layer.h"

namespace pickbed::eval {

// Returns the message for a training that is resumed although `file` is absent.
std::string NothingToResume(const std::filesystem::path& file);

// Prints what a stopped training has kept. `file` may not exist yet; `content` is what it keeps.
void SayStopped(const std::filesystem::path& file, const std::string& content);

}  // namespace pickbed::eval
