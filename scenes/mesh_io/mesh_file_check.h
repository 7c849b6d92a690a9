#pragma once

// Checks of a mesh file before an importer reads it.

#include <cstddef>
#include <filesystem>
#include <string>

namespace pickbed::scenes {

// Returns the extension of a file in lower case, with its dot.
std::string LowerExtension(const std::filesystem::path& path);

// Throws InputError that names the file and the reason, with the usual remedies.
[[noreturn]] void RefuseUnreadable(const std::filesystem::path& path, const std::string& reason);

// Throws InputError for more faces than kMaxMeshFaces.
void CheckFaceCount(const std::filesystem::path& path, size_t faces);

// Checks the header and the end of the file. Throws InputError if the header has no end, names more
// elements than the file has room for or too many faces, or if a text STL is cut short.
void CheckMeshFile(const std::filesystem::path& path);

// Returns the number of faces that the header names; 0 if the format has no such number.
size_t FacesInHeader(const std::filesystem::path& path);

}  // namespace pickbed::scenes
