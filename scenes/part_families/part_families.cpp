#include "scenes/part_families/part_families.h"

#include <array>

#include "scenes/part_families/part_makers.h"

namespace pickbed::scenes {

std::span<const PartRow> PartTable() {
  static constexpr std::array kTable = {
      PartRow{"bracket", "angle bracket with rib, boss and two holes; no symmetry", MakeBracket},
      PartRow{"rod", "connecting rod with two eyes of different size; C2 along its length",
              MakeRod},
      PartRow{"pipe_tee", "T of pipe, hollow; C2 about the branch", MakePipeTee},
      PartRow{"u_clip", "U of sheet with hooks; C2", MakeUClip},
      PartRow{"flange", "disc with hub, bore and six bolt holes; C6", MakeFlange},
      PartRow{"hex_bolt", "hexagon bolt M12 without threads; C6", MakeHexBolt},
      PartRow{"gear", "spur gear of twelve teeth with bore; D12", MakeGear},
      PartRow{"elbow", "pipe bend of 90 degrees with a collar at one end; no symmetry", MakeElbow},
      PartRow{"carton", "printed box; D2 of the shape, although the print breaks it", MakeCarton},
      PartRow{"bottle", "closed bottle with cap; rotational symmetry about its axis", MakeBottle},
      PartRow{"mug", "hollow mug with handle; no symmetry", MakeMug},
      PartRow{"ring", "plain ring; rotational symmetry about its axis and C2 across it", MakeRing},
  };
  return kTable;
}

}  // namespace pickbed::scenes
