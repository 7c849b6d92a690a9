#pragma once

// What planner.completion names: a method of completion, the true shapes, or the file of a model.

#include <optional>

#include "eval/layer.h"
#include "perception/completion/shape_completer.h"

namespace pickbed::eval {

// Name of the true shapes in place of a method, which no method can exceed.
inline constexpr char kTrueShapes[] = "truth";

// Returns the options of a method (perception::CompleterTable()), or of a model file, whose kind
// gives the method. A text with a folder or the extension .net is a file. Throws InputError for a
// file that cannot be read. An unknown method is returned as it is.
perception::CompletionOptions CompletionNamed(const std::string& completion);

// Returns the model file that this method or file reads; nullopt if it reads none.
std::optional<std::filesystem::path> ModelFileOf(const std::string& completion);

}  // namespace pickbed::eval
