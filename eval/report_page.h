#pragma once

// The page of a report: one HTML file that holds its charts, pictures and 3D views and loads
// nothing from elsewhere. What is fixed of it is made at build by eval/report/page.

#include <string>
#include <vector>

#include "eval/report/charts.h"
#include "eval/report_data.h"

namespace pickbed {

struct GalleryEntry {
  LostPick pick;
  std::string address;  // "results/demo#3"
  std::string jpeg;     // empty = no picture
};

struct ReportView {
  std::string title;  // "picked", "lost: slipped"
  std::string address;
  std::string glb;  // of eval/report_views.h
};

struct ReportTable {
  std::string title, text;
  TableCells cells;
};

struct ReportContents {
  std::string title;
  std::vector<std::string> about;  // paragraphs
  std::vector<PointReport> points;
  std::vector<ReportTable> comparisons;  // paired differences
  std::vector<GalleryEntry> gallery;
  int lost = 0;              // picks, of which the gallery shows some
  std::string gallery_note;  // what was left out
  std::vector<ReportView> views;
  std::string views_note;
};

// The page with this body, of page_parts.h; with the library for 3D views or without. Throws
// InputError when this build has no page to fill in.
std::string FilledPage(const std::string& title, const std::string& body, bool has_views = false);

// Throws as FilledPage.
std::string ReportPage(const ReportContents& contents);

}  // namespace pickbed
