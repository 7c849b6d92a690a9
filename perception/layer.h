#pragma once

// pickbed::perception sees the names of the layers below it without qualification. A name that it
// declares itself hides an equal name of a lower layer.

namespace pickbed::scenes {}

namespace pickbed::perception {
using namespace scenes;
}  // namespace pickbed::perception
