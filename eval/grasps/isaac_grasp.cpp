#include "eval/grasps/isaac_grasp.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"
#include "scenes/base/settings_tree.h"

namespace pickbed::eval {
namespace {

using Kind = SettingsTree::Kind;

// Text of a value without the quotes of YAML.
std::string Unquoted(const std::string& text) {
  const bool is_quoted = text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
                         text.front() == text.back();
  return is_quoted ? text.substr(1, text.size() - 2) : text;
}

std::string TextOf(const SettingsTree& map, const std::string& key) {
  const SettingsTree* item = map.Find(key);
  return item == nullptr || item->kind != Kind::kValue || item->text == "~" ? ""
                                                                            : Unquoted(item->text);
}

const SettingsTree& Required(const SettingsTree& map, const std::string& key) {
  const SettingsTree* item = map.Find(key);
  CheckInput(item != nullptr, fmt::format("{}: grasp '{}' has no {}", map.place, map.key, key));
  return *item;
}

double NumberOf(const SettingsTree& item, const std::string& what) {
  const std::string text = Unquoted(item.text);
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  double value = 0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  CheckInput(item.kind == Kind::kValue && error == std::errc() &&
                 end == text.data() + text.size() && std::isfinite(value),
             fmt::format("{}: {} = {}: must be a finite number", item.place, what, item.text));
  constexpr double kSmallest = 1e-100;  // rounding of a zero gives larger numbers
  CheckInput(value == 0 || std::abs(value) > kSmallest || what == "confidence",
             fmt::format("{}: {} = {}: is too small for a length or an angle; get the file again",
                         item.place, what, item.text));
  return value;
}

Eigen::Vector3d VectorOf(const SettingsTree& item, const std::string& what) {
  CheckInput(
      item.kind == Kind::kList && item.items.size() == 3,
      fmt::format("{}: {} = {}: must be a list of three numbers", item.place, what, item.text));
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = NumberOf(item.items[i], what);
  return v;
}

Eigen::Matrix3d RotationOf(const SettingsTree& item) {
  constexpr double kMaxLengthError = 1e-3;
  const std::string key = "orientation";
  const SettingsTree *w = item.Find("w"), *xyz = item.Find("xyz");
  CheckInput(item.kind == Kind::kMap && w != nullptr && xyz != nullptr,
             fmt::format("{}: {} = {}: must have w and xyz", item.place, key, item.text));
  const Eigen::Vector3d v = VectorOf(*xyz, key + ".xyz");
  const Eigen::Quaterniond q(NumberOf(*w, key + ".w"), v.x(), v.y(), v.z());
  CheckInput(std::abs(q.norm() - 1) < kMaxLengthError,
             fmt::format("{}: {} = {}: must be a unit quaternion, but its length is {:.4g}",
                         item.place, key, item.text, q.norm()));
  return q.normalized().toRotationMatrix();
}

// Programs add keys of their own.
void RequireNoDamagedKey(const SettingsTree& grasp) {
  for (const SettingsTree& item : grasp.items) {
    for (const char* key : {"confidence", "cspace_position", "pregrasp_cspace_position"}) {
      CheckInput(!IsDamagedKey(item.key, key),
                 fmt::format("{}: grasp '{}' has the unknown key '{}'; did you mean {}?",
                             item.place, grasp.key, OneLine(item.key), key));
    }
  }
}

void RequireJoints(const SettingsTree& grasp, const std::string& key) {
  const SettingsTree* joints = grasp.Find(key);
  if (joints == nullptr || joints->kind != Kind::kMap) return;
  for (const SettingsTree& joint : joints->items) NumberOf(joint, key + "." + joint.key);
}

// Distance of the contacts, if the joints are the distances of two pads from the center.
std::optional<double> WidthOf(const SettingsTree& grasp) {
  const SettingsTree* joints = grasp.Find("cspace_position");
  if (joints == nullptr || joints->kind != Kind::kMap) return std::nullopt;
  const SettingsTree *left = joints->Find("left_finger"), *right = joints->Find("right_finger");
  if (left == nullptr || right == nullptr) return std::nullopt;
  const double width_m = NumberOf(*left, "left_finger") + NumberOf(*right, "right_finger");
  return width_m >= 0 ? std::optional(width_m) : std::nullopt;
}

// The scale is one number, or one for each axis.
void RequireNoScale(const SettingsTree& scale) {
  const auto is_one = [](const SettingsTree& item) { return NumberOf(item, "object_scale") == 1; };
  const bool is_list = scale.kind == Kind::kList;
  CheckInput(is_list ? std::ranges::all_of(scale.items, is_one) : is_one(scale),
             fmt::format("{}: object_scale = {}: must be 1; the grasps are of a mesh in another "
                         "size: add the scaled mesh as an object, scale the positions, and write 1",
                         scale.place, scale.text));
}

}  // namespace

GraspFile ReadIsaacGrasps(const std::string& text, const std::string& name) {
  const SettingsTree tree = ReadSettingsTreeText(text, name);
  CheckInput(TextOf(tree, "format") == "isaac_grasp",
             fmt::format("{}: format = '{}': must be isaac_grasp", name, TextOf(tree, "format")));
  const std::string version = TextOf(tree, "format_version");
  CheckInput(version == "1.0" || version == "1",
             fmt::format("{}: format_version = '{}': this pickbed reads 1.0", name, version));
  GraspFile file;
  file.file = name;
  file.object_file = TextOf(tree, "object_file");
  file.gripper_file = TextOf(tree, "gripper_file");
  if (const SettingsTree* axis = tree.Find("approach_axis")) {
    const double number = NumberOf(*axis, "approach_axis");
    CheckInput(number == 0 || number == 1 || number == 2,
               fmt::format("{}: approach_axis = {}: must be 0 (x), 1 (y) or 2 (z)", axis->place,
                           axis->text));
    file.approach_axis = static_cast<int>(number);
  }
  if (const SettingsTree* scale = tree.Find("object_scale")) RequireNoScale(*scale);
  const SettingsTree* grasps = tree.Find("grasps");
  CheckInput(grasps != nullptr && grasps->kind == Kind::kMap && !grasps->items.empty(),
             fmt::format("{}: has no grasps; they are a map from names to grasps", name));
  for (const SettingsTree& item : grasps->items) {
    CheckInput(item.kind == Kind::kMap,
               fmt::format("{}: grasp '{}' is no map of its values", item.place, item.key));
    FileGrasp& grasp = file.grasps.emplace_back();
    grasp.place = item.place;
    grasp.name = item.key;
    grasp.X_OF = MakePose(RotationOf(Required(item, "orientation")),
                          VectorOf(Required(item, "position"), "position"));
    if (const SettingsTree* confidence = item.Find("confidence")) {
      grasp.confidence = NumberOf(*confidence, "confidence");
    }
    RequireNoDamagedKey(item);
    for (const char* key : {"cspace_position", "pregrasp_cspace_position"}) {
      RequireJoints(item, key);
    }
    grasp.width_m = WidthOf(item);
  }
  return file;
}

}  // namespace pickbed::eval
