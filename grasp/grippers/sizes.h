#pragma once

#include "scenes/settings.h"

namespace pickbed {

// A size of zero would make a hand that touches nothing; a tenth of a millimetre is below any
// gripper that is built.
inline constexpr Range kGripperSize{1e-4, 1.0};

}  // namespace pickbed
