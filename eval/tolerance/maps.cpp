#include "eval/tolerance/maps.h"

#include "eval/trial/pose_matching.h"
#include "grasp/grippers/table.h"

namespace pickbed::eval {
namespace {

bool MatchesAnInstance(const HypothesisRecord& hypothesis) {
  return hypothesis.instance >= 0 && hypothesis.mssd_diameters() < kMatchDiameters;
}

}  // namespace

ToleranceMaps::ToleranceMaps(const std::vector<std::string>& places, const ObjectSet& objects,
                             const std::string& gripper) {
  if (!places.empty()) by_object_ = LoadToleranceModels(places, objects, gripper);
}

const ToleranceModel* ToleranceMaps::Of(ObjectId object) const {
  if (empty()) return nullptr;
  const auto& model = by_object_.at(object);
  return model ? &*model : nullptr;
}

std::optional<double> ToleranceMaps::PickChance(const HypothesisRecord& hypothesis) const {
  const ToleranceModel* model = Of(hypothesis.object);
  if (model == nullptr) return std::nullopt;
  if (!MatchesAnInstance(hypothesis)) return 0;
  return SuccessProbability(*model, hypothesis.X_OE);
}

std::optional<double> ToleranceMaps::PickChance(const HypothesisRecord& hypothesis,
                                                const Grasp& grasp) const {
  const ToleranceModel* model = Of(hypothesis.object);
  if (model == nullptr) return std::nullopt;
  if (!MatchesAnInstance(hypothesis)) return 0;
  return SuccessProbability(*model, hypothesis.X_OE, hypothesis.X_WO.inverse() * grasp.X_WG);
}

ToleranceMaps MapsFor(const ScenarioSpec& spec, const ObjectSet& objects,
                      const std::vector<std::string>& places) {
  if (places.empty()) return {};
  const auto gripper = WithSettingsKey(spec, "gripper", [&] {
    CheckInput(
        spec.gripper.names.size() == 1,
        fmt::format("= {}: a tolerance map is for one gripper; name one, or leave out the maps",
                    spec.gripper.InWords()));
    return LoadGripper(spec.gripper.names[0]);
  });
  return ToleranceMaps(places, objects, gripper->name);
}

}  // namespace pickbed::eval
