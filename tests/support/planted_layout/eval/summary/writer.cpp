#include <string>

namespace pickbed::eval {

// A planted fault for the layout test: a name that is a constant elsewhere.
std::string TrialsOf(const std::string& folder) { return folder + "/trials.csv"; }

}  // namespace pickbed::eval
