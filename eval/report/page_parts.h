#pragma once

// Pieces of a report's body as HTML. Text is escaped, bytes are Base64.

#include <string>

#include "eval/report/charts.h"

namespace pickbed {

std::string Base64(const std::string& bytes);

// As HtmlPage::Table, in a box that scrolls by itself where the screen is narrow.
std::string TableHtml(const TableCells& cells);
// Chart, caption and, folded, the table of its numbers.
std::string ChartHtml(const ReportChart& chart);

}  // namespace pickbed
