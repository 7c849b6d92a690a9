#pragma once

// The makers behind PartTable(), one a family. Dimensions stand at the top of each in millimetres.

#include "scenes/part_families.h"

namespace pickbed {

// part_families_flat.cpp: plates, prisms and turned parts
MadePart MakeBracket();
MadePart MakeUClip();
MadePart MakeHexBolt();
MadePart MakeFlange();
MadePart MakeGear();
MadePart MakeRing();

// part_families_joined.cpp: shapes that meet other shapes
MadePart MakeRod();
MadePart MakePipeTee();

// part_families_bent.cpp: tubes along curves
MadePart MakeElbow();
MadePart MakeMug();

// part_families_packed.cpp: goods
MadePart MakeCarton();
MadePart MakeBottle();

}  // namespace pickbed
