#include "eval/cli/train_messages.h"

#include <fmt/format.h>

namespace pickbed::eval {

std::string NothingToResume(const std::filesystem::path& file) {
  return fmt::format("no {} to resume from; remove --resume to start anew", file.string());
}

void SayStopped(const std::filesystem::path& file, const std::string& content) {
  if (std::filesystem::exists(file)) {
    fmt::print(stderr,
               "pickbed: stopped; {} keeps {}; repeat the same command with --resume to continue "
               "from there\n",
               file.string(), content);
  } else {
    fmt::print(stderr, "pickbed: stopped before anything was trained that could be kept\n");
  }
}

}  // namespace pickbed::eval
