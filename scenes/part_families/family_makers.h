#pragma once

// The functions behind FamilyTable(), by family. Each one starts with its dimensions in
// millimetres.

#include "scenes/part_families/part_families.h"

namespace pickbed::scenes {

// flat.cpp: plates, prisms and bodies of revolution
FamilyObject MakeBracket();
FamilyObject MakeUClip();
FamilyObject MakeHexBolt();
FamilyObject MakeFlange();
FamilyObject MakeGear();
FamilyObject MakeRing();

// joined.cpp: shapes that are joined to other shapes
FamilyObject MakeRod();
FamilyObject MakePipeTee();

// bent.cpp: tubes along curves
FamilyObject MakeElbow();
FamilyObject MakeMug();

// packed.cpp: packaged goods
FamilyObject MakeCarton();
FamilyObject MakeBottle();

}  // namespace pickbed::scenes
