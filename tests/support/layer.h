#pragma once

// Makes the names of all layers visible to tests without qualification.

namespace pickbed::scenes {}
namespace pickbed::sim {}
namespace pickbed::perception {}
namespace pickbed::grasp {}
namespace pickbed::eval {}

namespace pickbed::tests {
using namespace scenes;
using namespace sim;
using namespace perception;
using namespace grasp;
using namespace eval;
}  // namespace pickbed::tests
