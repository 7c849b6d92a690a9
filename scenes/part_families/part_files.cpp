#include "scenes/objects/object_writer.h"
#include "scenes/part_families/part_families.h"

namespace pickbed::scenes {

void WritePart(const PartRow& row, const std::filesystem::path& folder) {
  MadePart part = row.make();
  ObjectRecord record;
  record.help = row.help;
  record.mesh_O = std::move(part.mesh_O);
  record.convex_parts_O = std::move(part.convex_parts_O);
  record.symmetries_O = std::move(part.symmetries_O);
  record.density_kgpm3 = part.density_kgpm3;
  record.friction = part.friction;
  WriteObject(record, folder);
}

}  // namespace pickbed::scenes
