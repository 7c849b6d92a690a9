#include "perception/completion/shape_completer.h"

#include <fmt/format.h>

#include "perception/completion/completion_file.h"
#include "perception/completion/completion_input.h"
#include "perception/completion/nearest_shape.h"
#include "perception/completion/network_completer.h"
#include "perception/completion/rule_completers.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

constexpr int kNearestShapeViews = 2000;
// Names of CompletionKinds().
constexpr const char* kImplicitKind = "implicit";
constexpr const char* kVaeKind = "vae";

class NetworkCompleter : public ShapeCompleter {
 public:
  // `kind` is the kind that the model must have.
  NetworkCompleter(const CompletionOptions& options, const std::string& kind, int turns)
      : model_(LoadCompletionModel(TrainedFile(options.model))),
        cells_(options.cells),
        turns_(turns) {
    const std::string& own = model_.info.network.kind;
    CheckInput(own == kind,
               fmt::format("{}: is a model of kind {}, but method {} needs kind {}; train one with "
                           "`pickbed train completion --set network.kind={}` and name its file",
                           TrainedFile(options.model).string(), own, options.method, kind, kind));
  }
  CompletedVolume Complete(const SegmentView& view) override {
    return CompleteWithNetwork(model_.network, view, cells_, turns_);
  }
  std::vector<CompletedVolume> CompleteAll(std::span<const SegmentView> views) override {
    return CompleteAllWithNetwork(model_.network, views, cells_, turns_);
  }

 private:
  CompletionModel model_;
  int cells_, turns_;
};

using Made = std::unique_ptr<ShapeCompleter>;

Made MakeNetwork(const CompletionOptions& o) {
  return std::make_unique<NetworkCompleter>(o, kImplicitKind, o.turns);
}
// A view is aligned before it is encoded, so turned copies are equal.
Made MakeVae(const CompletionOptions& o) {
  return std::make_unique<NetworkCompleter>(o, kVaeKind, 1);
}
Made MakeLocalThickness(const CompletionOptions& o) {
  return MakeRuleCompleter(CompletionRule::kLocalThickness, o);
}
Made MakeSkirt(const CompletionOptions& o) { return MakeRuleCompleter(CompletionRule::kSkirt, o); }
Made MakeMirror(const CompletionOptions& o) {
  return MakeRuleCompleter(CompletionRule::kMirror, o);
}
Made MakeExtrusion(const CompletionOptions& o) {
  return MakeRuleCompleter(CompletionRule::kExtrusion, o);
}
Made MakeNearestShape(const CompletionOptions& o) {
  std::vector<const ShapeFamilyRow*> families;
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    if (!row.held_out) families.push_back(&row);
  }
  return std::make_unique<NearestShape>(families, kNearestShapeViews, o.cells);
}

}  // namespace

std::vector<CompletedVolume> ShapeCompleter::CompleteAll(std::span<const SegmentView> views) {
  std::vector<CompletedVolume> volumes(views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    try {
      volumes[i] = Complete(views[i]);
    } catch (const InputError&) {
      volumes[i] = {};  // too few readings, or none with an extent
    }
  }
  return volumes;
}

void CompletionOptions::Visit(SettingsVisitor& v) {
  v.Text("method", method, CompleterNames(), "method that completes the shape");
  v.Text("model", model, {}, "model file of methods network and vae, or a name in assets/models");
  v.Integer("cells", cells, {8, 256}, "cells along each axis of the completed cube");
  v.Integer("turns", turns, {1, kCubeTurns},
            "turned copies of the view whose probabilities method network averages");
  v.Real("skirt_m", skirt_m, {0.001, 0.2}, "depth of method skirt behind the seen surface, m");
}

const std::vector<CompleterRow>& CompleterTable() {
  static const std::vector<CompleterRow> table{
      {"network", "implicit decoder on a 3D U-Net, trained on sampled shapes", MakeNetwork,
       kImplicitKind},
      {"vae", "variational auto-encoder of volumes: reconstruct, sample, clamp", MakeVae, kVaeKind},
      {"local_thickness", "as deep as the widest circle in the silhouette", MakeLocalThickness},
      {"skirt", "a constant depth behind the seen surface", MakeSkirt},
      {"mirror", "the seen surface and its mirror image at its deepest point", MakeMirror},
      {"extrusion", "the silhouette drawn back by its smaller width", MakeExtrusion},
      {"nearest_shape", "the true shape of the nearest of 2000 training views", MakeNearestShape},
  };
  return table;
}

std::vector<std::string> CompleterNames() {
  std::vector<std::string> names;
  for (const CompleterRow& row : CompleterTable()) names.push_back(row.name);
  return names;
}

std::unique_ptr<ShapeCompleter> MakeCompleter(const CompletionOptions& options) {
  for (const CompleterRow& row : CompleterTable()) {
    if (row.name != options.method) continue;
    CheckSettings("CompletionOptions", options);
    return row.make(options);
  }
  throw InputError(UnknownNameMessage("completion method", options.method, CompleterNames()));
}

}  // namespace pickbed::perception
