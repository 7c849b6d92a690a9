// A planted fault for the include test: perception must not see sim.
#include "sim/drop.h"
