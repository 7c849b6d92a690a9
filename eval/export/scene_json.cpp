#include "eval/export/scene_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

namespace pickbed::eval {
namespace {

nlohmann::json Numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

ResultColumns SceneKeys() {
  return {
      {"bin.inner_size_m", "inner length, width and height of the bin"},
      {"bin.wall_m", "thickness of walls and floor"},
      {"bin.friction", "coefficient of friction of the bin"},
      {"objects[].instance", "number of the instance"},
      {"objects[].name", "name of the object"},
      {"objects[].position_m", "position of the object frame in the world frame: x, y, z"},
      {"objects[].quaternion_wxyz", "rotation from the object frame to the world frame"},
  };
}

ResultColumns CertificateKeys() {
  return {
      {"at_rest", "whether all instances came to rest in time"},
      {"simulated_s", "simulated time until then"},
      {"instances", "number of instances in the scene"},
      {"instances_outside", "number of instances that left the bin; they are not in the scene"},
      {"max_speed_mps", "largest final speed of a center of mass"},
      {"max_spin_radps", "largest final angular speed"},
      {"deepest_penetration_m", "deepest overlap of two bodies at rest"},
      {"wake_movement_m", "largest movement of a surface in one more second of simulation"},
      {"wake_movement_diameters", "the same, as a share of the object's diameter"},
      {"refused[].attempt", "number of a drop that failed the certificate"},
      {"refused[].faults", "reasons, one text each"},
      {"energy[].time_s", "simulated time"},
      {"energy[].kinetic_j", "kinetic energy of all instances"},
      {"energy[].potential_j", "potential energy of all instances"},
  };
}

std::string SceneJson(const Scene& scene, const ObjectSet& objects) {
  nlohmann::ordered_json json;
  json["bin"]["inner_size_m"] = Numbers(scene.bin.inner_size_m);
  json["bin"]["wall_m"] = scene.bin.wall_m;
  json["bin"]["friction"] = scene.bin.friction;
  json["objects"] = nlohmann::ordered_json::array();
  for (const PosedObject& posed : scene.objects) {
    const Eigen::Quaterniond q(posed.X_WO.linear());
    nlohmann::ordered_json item;
    item["instance"] = int{posed.instance};
    item["name"] = objects[posed.object]->name;
    item["position_m"] = Numbers(posed.X_WO.translation());
    item["quaternion_wxyz"] = {q.w(), q.x(), q.y(), q.z()};
    json["objects"].push_back(std::move(item));
  }
  return json.dump(2) + "\n";
}

std::string CertificateJson(const CertifiedScene& made) {
  const SceneCertificate& c = made.certificate;
  nlohmann::ordered_json json;
  json["at_rest"] = c.at_rest;
  json["simulated_s"] = c.simulated_s;
  json["instances"] = made.scene.objects.size();
  json["instances_outside"] = c.instances_outside;
  json["max_speed_mps"] = c.max_speed_mps;
  json["max_spin_radps"] = c.max_spin_radps;
  json["deepest_penetration_m"] = c.deepest_penetration_m;
  json["wake_movement_m"] = c.wake_movement_m;
  json["wake_movement_diameters"] = c.wake_movement_diameters;
  json["refused"] = nlohmann::ordered_json::array();
  for (const RefusedScene& refused : made.refused) {
    json["refused"].push_back({{"attempt", refused.attempt}, {"faults", refused.faults}});
  }
  json["energy"] = nlohmann::ordered_json::array();
  for (const EnergySample& sample : c.energy) {
    json["energy"].push_back({{"time_s", sample.time_s},
                              {"kinetic_j", sample.kinetic_j},
                              {"potential_j", sample.potential_j}});
  }
  return json.dump(1) + "\n";
}

std::string CertificateText(const CertifiedScene& made) {
  const SceneCertificate& c = made.certificate;
  std::string text;
  const auto line = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:<29}{}\n", name, value);
  };
  for (const RefusedScene& refused : made.refused) {
    line(fmt::format("rejected drop {}", refused.attempt).c_str(),
         fmt::format("{}", fmt::join(refused.faults, ", ")));
  }
  line("instances in the bin", std::to_string(made.scene.objects.size()));
  line("simulated", fmt::format("{:.2f} s", c.simulated_s));
  line("movement in one more second",
       fmt::format("{:.2f} mm, {:.2f} % of the instance's diameter", 1e3 * c.wake_movement_m,
                   100 * c.wake_movement_diameters));
  line("fastest instance",
       fmt::format("{:.2f} mm/s, {:.3f} rad/s", 1e3 * c.max_speed_mps, c.max_spin_radps));
  line("deepest overlap", fmt::format("{:.2f} mm", 1e3 * c.deepest_penetration_m));
  return text;
}

}  // namespace pickbed::eval
