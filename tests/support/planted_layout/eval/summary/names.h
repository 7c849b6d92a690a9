#pragma once

namespace pickbed::eval {

inline constexpr char kTrialsFile[] = "trials.csv";

}  // namespace pickbed::eval
