#include <filesystem>

namespace pickbed::scenes {

// A planted fault for the layout test: a file name that is written twice.
void Copy(const std::filesystem::path& from, const std::filesystem::path& to) {
  const std::filesystem::path source = from / "made.json";
  std::filesystem::copy_file(source, to / "made.json");
}

}  // namespace pickbed::scenes
