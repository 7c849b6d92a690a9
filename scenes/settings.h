#pragma once

// Settings structs and their text form. A settings struct has one Visit() that names each field
// with its range, unit and help; the file reader, --set, the writer of effective settings and the
// help text all go through it, so they cannot disagree.
//
//   struct BinSettings {
//     double wall_m = 0.006;
//     void Visit(SettingsVisitor& v) {
//       v.Real("wall_m", wall_m, {0.001, 0.05}, "thickness of the walls, m");
//     }
//   };
//
// Errors are InputError with one line: file:line, key, value, what is allowed, nearest known key.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace pickbed {

struct Range {
  double min;
  double max;
};

class SettingsVisitor {
 public:
  virtual ~SettingsVisitor() = default;
  virtual void Real(const char* key, double& value, Range range, const char* help) = 0;
  virtual void Integer(const char* key, int& value, Range range, const char* help) = 0;
  virtual void Seed(const char* key, uint64_t& value, const char* help) = 0;
  virtual void Bool(const char* key, bool& value, const char* help) = 0;
  // `choices` empty = any text.
  virtual void Text(const char* key, std::string& value, const std::vector<std::string>& choices,
                    const char* help) = 0;
  virtual void Vector2(const char* key, Eigen::Vector2d& value, Range range, const char* help) = 0;
  virtual void Vector3(const char* key, Eigen::Vector3d& value, Range range, const char* help) = 0;
  // A nested map.
  virtual void Group(const char* key, const std::function<void(SettingsVisitor&)>& visit,
                     const char* help) = 0;
  // A list of maps: `resize` is told how many there are, `visit` is called for each.
  virtual void List(const char* key, size_t size, const std::function<void(size_t)>& resize,
                    const std::function<void(size_t, SettingsVisitor&)>& visit,
                    const char* help) = 0;
};

using VisitFunction = std::function<void(SettingsVisitor&)>;

// Where each key was given: "objects.0.name" -> "demo.yaml:7". For errors that show only later.
using KeyPlaces = std::map<std::string, std::string>;

// Reads a YAML file into what `visit` names; keys that the file leaves out keep their values.
KeyPlaces ReadSettingsFile(const std::filesystem::path& file, const VisitFunction& visit);
KeyPlaces ReadSettingsText(const std::string& yaml, const std::string& name_for_errors,
                           const VisitFunction& visit);

// Applies one "a.b.c=value" (value in YAML; list items by index: "objects.0.count=3").
KeyPlaces ApplySetting(const std::string& assignment, const VisitFunction& visit);

// The effective settings as YAML, every key, help as comments when asked.
std::string WriteSettings(const VisitFunction& visit, bool with_help = false);

}  // namespace pickbed
