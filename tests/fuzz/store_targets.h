#pragma once

// Fuzz targets that read results stores.

#include "tests/fuzz/targets.h"

namespace pickbed::tests {

// The bytes are the file.
FuzzTarget StoreTarget();
// The bytes are edits of rows of a store, one on each line.
FuzzTarget StoreSqlTarget();

}  // namespace pickbed::tests
