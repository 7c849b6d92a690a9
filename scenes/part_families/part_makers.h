#pragma once

// The functions behind PartTable(), by family. Each one starts with its dimensions in millimetres.

#include "scenes/part_families/part_families.h"

namespace pickbed::scenes {

// flat.cpp: plates, prisms and bodies of revolution
MadePart MakeBracket();
MadePart MakeUClip();
MadePart MakeHexBolt();
MadePart MakeFlange();
MadePart MakeGear();
MadePart MakeRing();

// joined.cpp: shapes that are joined to other shapes
MadePart MakeRod();
MadePart MakePipeTee();

// bent.cpp: tubes along curves
MadePart MakeElbow();
MadePart MakeMug();

// packed.cpp: packaged goods
MadePart MakeCarton();
MadePart MakeBottle();

}  // namespace pickbed::scenes
