#include "scenes/mesh_io/mesh_file_check.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "scenes/base/error.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

constexpr size_t kStlHeader = 84, kStlFace = 50;  // bytes of a binary STL

// Reads the header of a PLY file. assimp 5.2 never returns from one without end. Returns the number
// of faces.
size_t CheckPlyHeader(const fs::path& path) {
  constexpr size_t kLongestLine = 4096;
  const uintmax_t size = fs::file_size(path);
  std::ifstream file(path, std::ios::binary);
  std::string line;
  size_t faces = 0;
  for (bool first = true; std::getline(file, line); first = false) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line == "end_header") return faces;
    if (first && line != "ply") break;
    if (line.size() > kLongestLine) break;
    size_t count = 0;
    if (std::sscanf(line.c_str(), "element face %zu", &count) == 1) {
      faces = count;
      CheckFaceCount(path, faces);
    }
    if (std::sscanf(line.c_str(), "element %*s %zu", &count) != 1) continue;
    // Each element takes a byte or more.
    if (count > size) {
      RefuseUnreadable(path, fmt::format("its header names {} elements, which {} bytes have no "
                                         "room for",
                                         count, size));
    }
  }
  RefuseUnreadable(path, "it has no PLY header, or one without end");
}

// A text STL ends with "endsolid". A binary one can begin with "solid", too.
void CheckStl(const fs::path& path) {
  const uintmax_t size = fs::file_size(path);
  std::ifstream file(path, std::ios::binary);
  std::array<char, kStlHeader> header{};
  file.read(header.data(), kStlHeader);
  if (file) {
    uint32_t faces = 0;
    std::memcpy(&faces, header.data() + 80, sizeof(faces));
    if (size == kStlHeader + kStlFace * faces) return CheckFaceCount(path, faces);
  }
  if (std::strncmp(header.data(), "solid", 5) != 0) return;
  constexpr std::streamoff kEnd = 512;  // a name can follow
  file.clear();
  file.seekg(std::max<std::streamoff>(0, static_cast<std::streamoff>(size) - kEnd));
  std::string end(std::istreambuf_iterator<char>(file), {});
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (end.find("endsolid") == std::string::npos) {
    RefuseUnreadable(path, "it does not end with endsolid, so it is cut short");
  }
}

// An OBJ has neither counts nor an end mark. But a file that is cut within a line can end with an
// incomplete element.
void CheckObj(const fs::path& path) {
  constexpr std::streamoff kEnd = 512;
  std::ifstream file(path, std::ios::binary);
  file.seekg(std::max<std::streamoff>(0, static_cast<std::streamoff>(fs::file_size(path)) - kEnd));
  const std::string end(std::istreambuf_iterator<char>(file), {});
  const size_t before = end.rfind('\n');
  std::istringstream line(before == std::string::npos ? end : end.substr(before + 1));
  std::string kind, word;
  line >> kind;
  if (kind != "v" && kind != "vn" && kind != "vt" && kind != "f" && kind != "l" && kind != "p")
    return;
  size_t words = 0;
  while (line >> word) ++words;
  const bool is_short =
      ((kind == "v" || kind == "vn" || kind == "f") && words < 3) || (kind == "vt" && words < 2);
  if (is_short || (!word.empty() && std::strchr("-+./eE", word.back()) != nullptr)) {
    RefuseUnreadable(path, "its last line is incomplete, so it is cut short");
  }
}

}  // namespace

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

[[noreturn]] void RefuseUnreadable(const fs::path& path, const std::string& reason) {
  // Messages of the importer end with a period.
  const std::string text = reason.ends_with('.') ? reason.substr(0, reason.size() - 1) : reason;
  throw InputError("cannot read mesh '" + path.string() + "': " + text +
                   "; check that the file is complete and that its extension matches its format "
                   "(.obj .ply .stl .dae .gltf .glb)");
}

void CheckFaceCount(const fs::path& path, size_t faces) {
  CheckInput(faces <= kMaxMeshFaces,
             fmt::format("mesh '{}' has {} faces; reduce it to {} or fewer, for instance with "
                         "MeshLab's quadric edge collapse",
                         path.string(), faces, kMaxMeshFaces));
}

void CheckMeshFile(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".ply") CheckPlyHeader(path);
  if (extension == ".stl") CheckStl(path);
  if (extension == ".obj") CheckObj(path);
}

size_t FacesInHeader(const fs::path& path) {
  return LowerExtension(path) == ".ply" ? CheckPlyHeader(path) : 0;
}

}  // namespace pickbed::scenes
