#pragma once

// Makes the names of lower layers visible in pickbed::sim without qualification. A name declared in
// pickbed::sim hides an equal name of a lower layer.

namespace pickbed::scenes {}

namespace pickbed::sim {
using namespace scenes;
}  // namespace pickbed::sim
