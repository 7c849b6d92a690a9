#include "scenes/part_families/part_families.h"

#include <array>

#include "scenes/part_families/family_makers.h"

namespace pickbed::scenes {

std::span<const FamilyRow> FamilyTable() {
  static constexpr std::array kTable = {
      FamilyRow{"bracket", "angle bracket with rib, boss and two holes; no symmetry", MakeBracket},
      FamilyRow{"rod", "connecting rod with two eyes of different size; C2 along its length",
                MakeRod},
      FamilyRow{"pipe_tee", "T of pipe, hollow; C2 about the branch", MakePipeTee},
      FamilyRow{"u_clip", "U of sheet with hooks; C2", MakeUClip},
      FamilyRow{"flange", "disc with hub, bore and six bolt holes; C6", MakeFlange},
      FamilyRow{"hex_bolt", "hexagon bolt M12 without threads; C6", MakeHexBolt},
      FamilyRow{"gear", "spur gear of twelve teeth with bore; D12", MakeGear},
      FamilyRow{"elbow", "pipe bend of 90 degrees with a collar at one end; no symmetry",
                MakeElbow},
      FamilyRow{"carton", "printed box; D2 of the shape, although the print breaks it", MakeCarton},
      FamilyRow{"bottle", "closed bottle with cap; rotational symmetry about its axis", MakeBottle},
      FamilyRow{"mug", "hollow mug with handle; no symmetry", MakeMug},
      FamilyRow{"ring", "plain ring; rotational symmetry about its axis and C2 across it",
                MakeRing},
  };
  return kTable;
}

}  // namespace pickbed::scenes
