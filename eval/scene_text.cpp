#include "eval/scene_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace pickbed {
namespace {

nlohmann::json Numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::string SceneJson(const Scene& scene, const ObjectSet& objects) {
  nlohmann::ordered_json json;
  json["bin"]["inner_size_m"] = Numbers(scene.bin.inner_size_m);
  json["bin"]["wall_m"] = scene.bin.wall_m;
  json["bin"]["friction"] = scene.bin.friction;
  json["objects"] = nlohmann::ordered_json::array();
  for (const PosedObject& posed : scene.objects) {
    const Eigen::Quaterniond q(posed.X_WO.linear());
    nlohmann::ordered_json item;
    item["instance"] = posed.instance;
    item["name"] = objects[posed.object]->name;
    item["position_m"] = Numbers(posed.X_WO.translation());
    item["quaternion_wxyz"] = {q.w(), q.x(), q.y(), q.z()};
    json["objects"].push_back(std::move(item));
  }
  return json.dump(2) + "\n";
}

std::string DropReportText(const DropReport& report, size_t parts) {
  std::string text;
  const auto line = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:<24}{}\n", name, value);
  };
  line("parts in the bin", std::to_string(parts));
  line("fell outside", std::to_string(report.left_bin));
  line("at rest", report.at_rest ? "yes" : "no: the time limit came first");
  line("simulated", fmt::format("{:.2f} s", report.simulated_s));
  line("fastest part", fmt::format("{:.1f} mm/s", 1e3 * report.max_speed_mps));
  line("deepest overlap", fmt::format("{:.2f} mm", 1e3 * report.deepest_penetration_m));
  if (report.blew_up) line("physics", "FAILED: a body's state is not finite or too fast");
  return text;
}

}  // namespace pickbed
