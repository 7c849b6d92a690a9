#pragma once

// Generated pages of the documentation: settings, commands and result files. They are made from the
// same tables and Visit() functions as the program's readers, writers and help.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/reference/setting_rows.h"

namespace pickbed::eval {

using Pages = std::map<std::string, std::string>;  // file name -> Markdown

// A kind of settings file, or a set of settings of a command.
struct SettingsSource {
  std::string title, intro;
  std::vector<SettingRow> rows;
};
// Settings on one page.
struct SettingsPage {
  std::string file, title;
  std::vector<SettingsSource> sources;
};
// Returns all settings, in the order of the reference.
std::vector<SettingsPage> AllSettings();

// A file that a command writes. A picture or page has no columns.
struct ResultFile {
  std::string name;
  std::string help;
  std::string column_title;  // "column" or "key"
  ResultColumns columns = {};
};
// Files that a command writes into its results folder.
struct ResultFolder {
  std::string title, intro;
  std::vector<ResultFile> files;
};
struct ResultPage {
  std::string file, title;
  std::vector<ResultFolder> folders;
};
// Returns all result files, in the order of the reference.
std::vector<ResultPage> AllResultFiles();

// Adds the pages of all settings.
void AddSettingsPages(Pages& pages);
// Adds the pages of all commands.
void AddCommandPages(Pages& pages);
// Adds the pages of all result files.
void AddFilePages(Pages& pages);

// Returns all pages.
Pages ReferencePages();
// Writes all pages into `folder`, which is created. Removes pages of an earlier version there, but
// no other files.
void WriteReference(const std::filesystem::path& folder);

}  // namespace pickbed::eval
