#include "eval/reference/pages.h"

#include "eval/reference/markdown.h"
#include "scenes/base/files.h"

namespace pickbed::eval {

Pages ReferencePages() {
  Pages pages;
  AddSettingsPages(pages);
  AddCommandPages(pages);
  AddFilePages(pages);
  return pages;
}

void WriteReference(const std::filesystem::path& folder) {
  const Pages pages = ReferencePages();
  MakeFolder(folder);
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".md") continue;
    if (pages.contains(entry.path().filename().string())) continue;
    const bool is_generated = ReadFileBytes(entry.path()).find(kGeneratedMark) != std::string::npos;
    if (is_generated) std::filesystem::remove(entry.path());
  }
  for (const auto& [name, text] : pages) WriteFileAtomically(folder / name, text);
}

}  // namespace pickbed::eval
