#pragma once

// Pools of objects: scenario entries that give many objects, and the objects that each bin draws
// from them.
//
//   objects:
//     - {name: sampled/machine/unseen_families/0-39}    # one object for each seed
//     - {name: ycb, mesh: meshes/ycb/*.obj, density_kgpm3: 300}   # ycb/FILE for each file
//   draw: 5                                             # each bin has five of them

#include <cstdint>
#include <vector>

#include "scenes/base/ids.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::scenes {

// Replaces each entry with a range of seeds or a pattern by one entry for each object, in the order
// of seeds or file names, with the other settings of the entry. Files that are no meshes are left
// out. Throws InputError for a malformed range, a pattern in a folder's name, a pattern that no
// mesh matches, and objects with equal names.
void ExpandObjects(ScenarioSpec& spec);

// Returns the number of instances of each object in a bin: all without `draw`, else drawn with the
// random stream of the bin.
std::vector<int> CountsInBin(const std::vector<ObjectSpec>& objects, int draw, uint64_t seed,
                             BinIndex bin_index);

}  // namespace pickbed::scenes
