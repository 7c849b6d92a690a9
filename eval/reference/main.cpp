#include <fmt/format.h>

#include <exception>

#include "eval/reference/pages.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "Usage: pickbed_make_reference OUT_FOLDER\n");
    return 1;
  }
  try {
    pickbed::eval::WriteReference(argv[1]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "pickbed_make_reference: {}\n", error.what());
    return 2;
  }
  return 0;
}
