// A planted fault for the include test: perception must not include sim.
#include "sim/drop/drop.h"
