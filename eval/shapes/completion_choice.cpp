#include "eval/shapes/completion_choice.h"

#include <algorithm>

#include "perception/completion/completion_file.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

bool IsFile(const std::filesystem::path& completion) {
  return completion.has_parent_path() || completion.extension() == ".net";
}

}  // namespace

perception::CompletionOptions CompletionNamed(const std::string& completion) {
  perception::CompletionOptions options;
  options.method = completion;
  if (!IsFile(completion)) return options;
  options.model = completion;
  const std::string kind =
      perception::LoadCompletionModel(TrainedFile(completion)).info.network.kind;
  const auto row = std::ranges::find_if(perception::CompleterTable(), [&](const auto& candidate) {
    return candidate.kind != nullptr && candidate.kind == kind;
  });
  options.method = row->name;
  return options;
}

std::optional<std::filesystem::path> ModelFileOf(const std::string& completion) {
  if (IsFile(completion)) return TrainedFile(completion);
  const bool reads_model = std::ranges::any_of(perception::CompleterTable(), [&](const auto& row) {
    return row.name == completion && row.kind != nullptr;
  });
  if (!reads_model) return std::nullopt;
  return TrainedFile(perception::CompletionOptions().model);
}

}  // namespace pickbed::eval
