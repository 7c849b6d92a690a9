#pragma once

// Replaces names of earlier versions in the texts of a results store, so that a run of now can be
// compared with a stored one.

#include <string>

#include "eval/store/results_store.h"

namespace pickbed::eval {

// Updates the identity (RunIdentity in eval/sweep/run.h) or the settings of a configuration.
std::string WithCurrentNames(const std::string& identity);

// Updates the name of a configuration, such as "estimator.mode=hard,sensor=ideal". Parts that are
// no settings are kept.
std::string NameWithCurrentNames(const std::string& name);

// Updates all texts of a store head.
StoreHead WithCurrentNames(const StoreHead& head);

}  // namespace pickbed::eval
