// pickbed_make_parts [OUT_DIR]: writes every object of the table as OUT_DIR/NAME/{mesh.obj, ...}.
// Without OUT_DIR it rewrites the shipped catalog. Every run gives the same bytes.

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>

#include "scenes/base/error.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/part_families/part_families.h"

int main(int argc, char** argv) {
  try {
    const std::filesystem::path out =
        argc > 1 ? std::filesystem::path(argv[1]) : pickbed::scenes::AssetsDir() / "objects";
    for (const pickbed::scenes::FamilyRow& row : pickbed::scenes::FamilyTable()) {
      pickbed::scenes::WriteFamilyObject(row, out / row.name);
      fmt::print("{}: {}\n", (out / row.name).string(), row.help);
    }
    return 0;
  } catch (const pickbed::scenes::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "pickbed_make_parts: {}\n", error.what());
    return 2;
  }
}
