#pragma once

// HTML page of a report. It holds its charts, pictures and 3D views in one file and loads nothing
// from other files. eval/page/web creates the fixed part of the page during the build.

#include <string>
#include <vector>

#include "eval/report/charts.h"
#include "eval/report/run_statistics.h"

namespace pickbed::eval {

// A failed pick in the gallery.
struct GalleryEntry {
  FailedPick pick;
  std::string address;  // such as "results/demo#3"
  std::string jpeg;     // empty = no picture
  std::string link;     // URL of the full picture, relative to the page; empty = none
};

// Settings of a configuration.
struct ShownScenario {
  std::string name;      // of the configuration; empty if there is only one
  std::string settings;  // YAML
  std::string link;      // URL of the scenario file, relative to the page; empty = none
};

// A 3D view.
struct ReportView {
  std::string title;  // such as "picked" or "failed: slipped"
  std::string address;
  std::string glb;  // GLB bytes from eval/report/views_3d.h
};

// Returns the 3D view with a switch for each layer that it has.
std::string ViewHtml(const ReportView& view);

// Content of the page.
struct ReportContents {
  std::string title;
  std::vector<std::string> about;  // paragraphs
  std::string overlay_jpeg;        // of the first attempt; empty = no picture
  std::vector<ConfigurationReport> configurations;
  // Settings that differ between two runs, with a header row. Empty: no such section.
  TableCells different_settings;
  std::vector<ReportTable> comparisons;  // paired differences
  std::vector<GalleryEntry> gallery;
  int failed_picks = 0;      // number of all failed picks
  std::string gallery_note;  // says what the gallery leaves out
  std::vector<ShownScenario> scenarios;
  std::vector<ReportView> picks;  // animated
  std::string picks_note;         // says what is left out
  std::vector<ReportView> views;
  std::string views_note;
};

// Returns the HTML page. Throws InputError if this build has no page template.
std::string ReportPage(const ReportContents& contents);

}  // namespace pickbed::eval
