#pragma once

// Settings under names of earlier versions. A settings struct declares them in its Visit() with
// SettingsVisitor::RenamedKey() and RenamedValue(). The functions here replace them in a text
// before it is read, so readers only know the names of now.

#include <functional>
#include <string>
#include <vector>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// A former name that was found and replaced.
struct ReplacedName {
  int line = 0;     // from 1; 0 = the key is not in the text but in front of it
  std::string was;  // "foreign" for a key, "mode: hard" for a value
  std::string is;   // "distractor", "mode: accurate"
  bool operator==(const ReplacedName&) const = default;
};

// A text with the current names. It keeps the line numbers of the original.
struct CurrentText {
  std::string text;
  std::vector<ReplacedName> replaced;  // ordered by position, each once
};

// Replaces former names in a YAML text of the settings that `visit` names. `visit` must be callable
// on default values; it changes none of them. Everything else in the text is kept. A text that is
// not valid YAML is returned as it is.
CurrentText WithCurrentNames(const std::string& yaml, const VisitFunction& visit);
// Same for one assignment "a.b.c=value".
CurrentText AssignmentWithCurrentNames(const std::string& assignment, const VisitFunction& visit);

// Formats as "FILE:3: 'foreign' is deprecated, write 'distractor'; line 9: ...". `replaced` must
// not be empty.
std::string DeprecationLine(const std::string& file, const std::vector<ReplacedName>& replaced);

// Receives one line for each file or assignment that uses former names.
using DeprecationListener = std::function<void(const std::string& line)>;
// Sets the listener of this process and returns the one before. It is called by ReadSettingsFile(),
// ApplySetting() and ReportDeprecation(). Without a listener, former names are read silently.
DeprecationListener SetDeprecationListener(DeprecationListener listener);
// Passes one line to the listener of this process.
void ReportDeprecation(const std::string& line);

}  // namespace pickbed::scenes
