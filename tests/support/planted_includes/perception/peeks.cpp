// Planted faults for the include test: perception must include neither sim nor ground truth.
#include "scenes/scene.h"
#include "sim/drop/drop.h"
