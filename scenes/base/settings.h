#pragma once

// Settings structs and their text form. A settings struct has one Visit() that names each field
// with its range, unit and help. The file reader, assignments, the writer of effective settings and
// the help text all use this function, so they always agree.
//
//   struct BinSettings {
//     double wall_m = 0.006;
//     void Visit(SettingsVisitor& v) {
//       v.Real("wall_m", wall_m, {0.001, 0.05}, "thickness of the walls, m");
//     }
//   };
//
// Errors are InputError with one line: file:line, key, value, allowed values, nearest known key.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace pickbed::scenes {

// Closed interval of allowed values.
struct Range {
  double min;
  double max;
};

// Interface that a settings struct's Visit() calls once for each field. A reader changes the value;
// a writer only reads it. `help` is one sentence with the unit.
class SettingsVisitor {
 public:
  virtual ~SettingsVisitor() = default;
  virtual void Real(const char* key, double& value, Range range, const char* help) = 0;
  virtual void Integer(const char* key, int& value, Range range, const char* help) = 0;
  virtual void Seed(const char* key, uint64_t& value, const char* help) = 0;
  virtual void Bool(const char* key, bool& value, const char* help) = 0;
  // Any text is allowed if `choices` is empty.
  virtual void Text(const char* key, std::string& value, const std::vector<std::string>& choices,
                    const char* help) = 0;
  // One name, or a list of at least one.
  virtual void Names(const char* key, std::vector<std::string>& value, const char* help) = 0;
  // A list of words, which may be empty. A text in place of a list is split at its spaces.
  virtual void Words(const char* key, std::vector<std::string>& value, const char* help) = 0;
  virtual void Vector2(const char* key, Eigen::Vector2d& value, Range range, const char* help) = 0;
  virtual void Vector3(const char* key, Eigen::Vector3d& value, Range range, const char* help) = 0;
  // A nested map.
  virtual void Group(const char* key, const std::function<void(SettingsVisitor&)>& visit,
                     const char* help) = 0;
  // A list of maps with `size` items. A reader first calls `resize` with the number of items in the
  // file. `visit` is called for each item.
  virtual void List(const char* key, size_t size, const std::function<void(size_t)>& resize,
                    const std::function<void(size_t, SettingsVisitor&)>& visit,
                    const char* help) = 0;
  // Declare a name of an earlier version of a key in this map, or of a value of a text. Call them
  // before the key. Readers accept both names (scenes/base/settings_names.h).
  virtual void RenamedKey(const char* /*was*/, const char* /*key*/) {}
  virtual void RenamedValue(const char* /*key*/, const char* /*was*/, const char* /*value*/) {}
};

using VisitFunction = std::function<void(SettingsVisitor&)>;

// Place of each given key, such as "objects.0.name" -> "demo.yaml:7". It is for errors that are
// detected after reading.
using KeyPlaces = std::map<std::string, std::string>;

// Reads a YAML file into the fields that `visit` names; fields without a key in the file keep their
// values. Names of earlier versions are accepted and reported (SetDeprecationListener()). Returns
// the place of each key. Throws InputError for a file that cannot be read or has no key, invalid
// YAML, unknown or repeated keys and values that are not allowed.
KeyPlaces ReadSettingsFile(const std::filesystem::path& file, const VisitFunction& visit);
// Same as ReadSettingsFile() for a YAML text that pickbed wrote, so names of earlier versions are
// not reported. Errors use `name_for_errors` as the file name.
KeyPlaces ReadSettingsText(const std::string& yaml, const std::string& name_for_errors,
                           const VisitFunction& visit);

// Beginning of the place of a setting that was given as an assignment: "setting a.b.c=value".
inline constexpr const char* kAssignmentPlace = "setting ";

// Applies one assignment "a.b.c=value", with the value in YAML and list items by index, such as
// "objects.0.count=3". Accepts and reports names of earlier versions. Returns and throws the same
// as ReadSettingsFile().
KeyPlaces ApplySetting(const std::string& assignment, const VisitFunction& visit);

// Values that are not allowed, for settings that were filled in C++ and not read. Returns "key =
// value: what is allowed" for each, in the words of the readers. `at` converts a key such as
// "objects.0.count" into its name in the message; empty = the key.
std::vector<std::string> SettingFaults(
    const VisitFunction& visit, const std::function<std::string(const std::string& key)>& at = {});

// Throws InputError that names every value that is not allowed, in one line that starts with
// `name`. Entry points of the libraries call it for their options. Not for inner loops.
void CheckSettings(const std::string& name, const VisitFunction& visit);
// Same for a struct with Visit().
template <typename Settings>
requires requires(Settings& settings, SettingsVisitor& v) { settings.Visit(v); }
void CheckSettings(const std::string& name, const Settings& settings) {
  Settings copy = settings;  // Visit() is not const, because readers set the values
  CheckSettings(name, VisitFunction([&copy](SettingsVisitor& v) { copy.Visit(v); }));
}

// Returns the effective settings as YAML with every key. `with_help` adds the help as comments.
std::string WriteSettings(const VisitFunction& visit, bool with_help = false);
// Returns the same settings with the names that they first had. For texts that are hashed or
// compared with stored ones: a new name of a key then keeps caches and checkpoints valid.
std::string WriteSettingsKey(const VisitFunction& visit);

}  // namespace pickbed::scenes
