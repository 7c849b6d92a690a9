// A planted fault for the include test: base is below geometry.
#include "scenes/geometry/pose.h"
