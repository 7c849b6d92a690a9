#pragma once

// The makers behind PartTable(), one a family. Dimensions stand at the top of each in millimetres.

#include "scenes/part_families.h"

namespace pickbed {

// part_families_flat.cpp: plates, prisms and turned parts of metal
MadePart MakeBracket();
MadePart MakeUClip();
MadePart MakeHexBolt();
MadePart MakeFlange();
MadePart MakeGear();
MadePart MakeRing();

// part_families_pipe.cpp: rods and pipes
MadePart MakeRod();
MadePart MakePipeTee();
MadePart MakeElbow();

// part_families_household.cpp
MadePart MakeCarton();
MadePart MakeBottle();
MadePart MakeMug();

}  // namespace pickbed
