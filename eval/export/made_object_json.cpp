#include "eval/export/made_object_json.h"

#include <nlohmann/json.hpp>

namespace pickbed::eval {

ResultColumns MadeObjectKeys() {
  return {
      {"key", "hash of the mesh, and all options"},
      {"unit", "unit of length of the mesh file, as given or guessed"},
      {"watertight", "whether the mesh is closed"},
      {"shells", "number of connected groups of faces"},
      {"put_right", "repairs of the mesh, one text each"},
      {"notes", "guesses and doubtful properties, one text each"},
      {"mass_from_hull", "whether the mass properties are from the hull, because the mesh is open"},
      {"volume_m3", "volume of the object"},
      {"pieces.count", "number of convex pieces for contact"},
      {"pieces.vertices", "number of their vertices"},
      {"pieces.bulge_m", "largest distance of a piece's surface outside the mesh to the mesh"},
      {"pieces.missed_m", "largest distance of the mesh's surface outside the pieces to them"},
      {"pieces.volume_error", "volume of the pieces over the volume of the mesh, minus 1"},
      {"seconds.STAGE", "duration of a stage", "s"},
  };
}

std::string MadeObjectJson(const std::string& key, const MadeObject& made) {
  nlohmann::ordered_json json;
  json["key"] = key;
  json["unit"] = made.inspected.unit;
  json["watertight"] = made.inspected.watertight;
  json["shells"] = made.inspected.shells;
  json["put_right"] = made.inspected.fixed;
  json["notes"] = made.inspected.notes;
  json["mass_from_hull"] = made.mass_from_hull;
  json["volume_m3"] = made.model.mass.volume_m3;
  json["pieces"] = {{"count", made.quality.pieces},
                    {"vertices", made.quality.vertices},
                    {"bulge_m", made.quality.bulge_m},
                    {"missed_m", made.quality.missed_m},
                    {"volume_error", made.quality.volume_error}};
  for (const MakeStageTime& stage : made.seconds) json["seconds"][stage.stage] = stage.seconds;
  return json.dump(1) + "\n";
}

}  // namespace pickbed::eval
