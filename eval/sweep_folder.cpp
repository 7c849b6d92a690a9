#include "eval/sweep_folder.h"

#include <fmt/format.h>

#include "scenes/check.h"
#include "scenes/files.h"

namespace pickbed {
namespace {

// SweepText in eval/sweep_spec.h writes that block last.
std::string WithoutSlurm(const std::string& yaml) { return yaml.substr(0, yaml.find("\nslurm:")); }

}  // namespace

void RequireNoOtherSweep(const std::filesystem::path& out, const std::string& yaml) {
  const std::filesystem::path file = out / "sweep.yaml";
  if (!std::filesystem::is_regular_file(file)) return;
  CheckInput(WithoutSlurm(ReadFileBytes(file)) == WithoutSlurm(yaml),
             fmt::format("{} is of a sweep with other settings; choose another folder with --out",
                         file.string()));
}

}  // namespace pickbed
