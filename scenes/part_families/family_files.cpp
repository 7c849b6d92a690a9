#include "scenes/objects/object_writer.h"
#include "scenes/part_families/part_families.h"

namespace pickbed::scenes {

void WriteFamilyObject(const FamilyRow& row, const std::filesystem::path& folder) {
  FamilyObject object = row.make();
  ObjectRecord record;
  record.help = row.help;
  record.mesh_O = std::move(object.mesh_O);
  record.convex_pieces_O = std::move(object.convex_pieces_O);
  record.symmetries_O = std::move(object.symmetries_O);
  record.density_kgpm3 = object.density_kgpm3;
  record.friction = object.friction;
  WriteObject(record, folder);
}

}  // namespace pickbed::scenes
