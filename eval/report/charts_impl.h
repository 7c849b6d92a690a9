#pragma once

// What the charts' specifications have in common.

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "eval/report/charts.h"

namespace pickbed {

using Json = nlohmann::ordered_json;

// A field of the data with the title of its axis or legend.
Json Field(const char* name, const char* type, const std::string& title);
// A share as an axis in percent; the whole of it when `whole`, else as far as the data reach.
Json PercentField(const char* name, const std::string& title, bool whole = true);

// Data and width; the rest is to be added.
Json EmptySpec(const Json& values);
// Of a chart of horizontal bars: `rows`, in each of which there is a bar of every series. (A height
// by steps would not go with a width that follows the page.)
int BarsHeight_px(size_t rows, size_t series);

// Names of the points, in order, for the scales of series.
std::vector<std::string> NamesOf(std::span<const PointReport> points);

// Colour of lines and points, with a legend where there is more than one.
Json SeriesColor(const char* field, const std::vector<std::string>& names);
Json SeriesShape(const char* field, const std::vector<std::string>& names);
Json SeriesDash(const char* field, const std::vector<std::string>& names);
// Fill of bars: a colour with a pattern.
Json SeriesFill(const char* field, const std::vector<std::string>& names);

// Layers of a curve with its band: `x` ordinal or quantitative, rates in `rate`, `low` and `high`,
// series in `series`.
Json CurveLayers(const Json& x, const Json& y, const std::vector<std::string>& names);

}  // namespace pickbed
