#pragma once

// Methods that complete the shape of an object from one view, and the table of these methods.

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/completion/completed_volume.h"
#include "perception/completion/segment_view.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct CompletionOptions {
  std::string method = "network";  // a row of CompleterTable()
  // Model file of methods network and vae, or name of a file in assets/models.
  std::string model = "completion";
  int cells = 64;          // along each axis of the cube
  int turns = 2;           // turned copies of the view that method network averages
  double skirt_m = 0.015;  // depth of the skirt behind the seen surface
  void Visit(SettingsVisitor& v);
};

// Completes segments of unknown objects. Each thread needs its own completer.
class ShapeCompleter {
 public:
  virtual ~ShapeCompleter() = default;
  // Returns the completed volume. Throws InputError as CheckSegmentView() does.
  virtual CompletedVolume Complete(const SegmentView& view) = 0;
  // Returns the completed volume of each view. It is empty where Complete() would throw.
  virtual std::vector<CompletedVolume> CompleteAll(std::span<const SegmentView> views);
};

struct CompleterRow {
  std::string name;
  std::string help;
  std::unique_ptr<ShapeCompleter> (*make)(const CompletionOptions& options);
  const char* kind = nullptr;  // of its model, see CompletionKinds(); null = it needs no model
};

// Returns all methods.
const std::vector<CompleterRow>& CompleterTable();
// Returns the names of its rows.
std::vector<std::string> CompleterNames();

// Returns the method `options.method`. Throws InputError for an unknown method, and for a missing,
// damaged or newer model file.
std::unique_ptr<ShapeCompleter> MakeCompleter(const CompletionOptions& options);

}  // namespace pickbed::perception
