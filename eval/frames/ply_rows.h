#pragma once

// The points of a PLY file as columns of numbers (Turk, "The PLY polygon file format", 1994).

#include <string>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

struct PlyRows {
  struct Column {
    std::string name;
    bool is_float = false;
    std::vector<double> values;  // one for each row
  };
  size_t rows = 0;
  std::vector<Column> columns;
  // Size of the image, from the element `camera` (viewportx, viewporty) or from comments and
  // obj_info lines with num_cols and num_rows, or width and height; 0 = not in the file.
  int width = 0, height = 0;
};

// Reads the element `vertex` of a binary_little_endian or ascii PLY file, and the size of the
// image. Throws InputError with `name` for damaged files and for lists before the points.
PlyRows ReadPlyRows(const std::string& bytes, const std::string& name);

}  // namespace pickbed::eval
