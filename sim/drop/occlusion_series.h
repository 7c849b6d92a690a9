#pragma once

// Occlusion series: scenes with one target that is increasingly occluded. Blockers are dropped one
// by one near the line of sight. For each band of visible fractions, a fraction is drawn uniformly,
// and the scene nearest to it is kept. (The first scene in a band is biased to the band's upper
// end.)
//
// While a blocker settles, the target and all other instances are static. So the target's pose is
// identical, bit for bit, in all scenes of a series. Then the whole scene must pass the certificate
// with all instances awake; otherwise the blocker is removed.

#include <vector>

#include "scenes/base/ids.h"
#include "scenes/base/random.h"
#include "scenes/camera/camera.h"
#include "scenes/scenario/occlusion_spec.h"
#include "sim/drop/certified_scene.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

// Fixed inputs of the occlusion series of a scenario.
struct OcclusionSetup {
  const ObjectSet& objects;  // must have convex pieces
  std::vector<int> counts;   // of each object in the scenario; weights of the blocker choice
  Camera camera;
  DropOptions drop;
  OcclusionSpec spec;
};

// Outcomes of the blockers that were dropped to fill one band.
struct BlockerCounts {
  int dropped = 0;
  int kept = 0;
  int refused = 0;  // the scene failed its certificate, or the blocker did not settle in the bin
  int jumped = 0;   // hid so much that the band was skipped
  int useless = 0;  // hid less than OcclusionSpec::min_hidden
  void Add(const BlockerCounts& other);
  friend bool operator==(const BlockerCounts&, const BlockerCounts&) = default;
};

// The scene of one band.
struct OccludedScene {
  int band = 0;
  double visible_fraction = 0;  // of the target
  int blockers = 0;             // they are the last entries of scene.objects
  Scene scene;
  SceneCertificate certificate;
};

struct OcclusionSeries {
  InstanceId target = kNoInstance;      // instance number
  std::vector<OccludedScene> scenes;    // one per filled band, the most visible first
  std::vector<BlockerCounts> blockers;  // one per band of the settings
};

// A settled scene without blockers.
struct SettledScene {
  const Scene& scene;
  const SceneCertificate& certificate;
};

// Returns the visible fraction of each entry of scene.objects.
std::vector<double> VisibleFractionsIn(SceneRenderer& renderer, const Scene& scene,
                                       const Camera& camera);

// Returns the instances of `wanted` objects that can be targets. Their initial visible fraction is
// at least the lower end of the most visible band. The order is the scene's order.
std::vector<InstanceId> PossibleTargets(SceneRenderer& renderer, const Scene& scene,
                                        const std::vector<ObjectId>& wanted,
                                        const OcclusionSetup& setup);

// Drops blockers until all bands are filled, or until OcclusionSpec::blocker_samples or
// max_blockers is reached. The result depends only on the arguments. Throws std::logic_error if
// `target` is not in the scene.
OcclusionSeries OccludeTarget(SceneRenderer& renderer, const SettledScene& start, InstanceId target,
                              const OcclusionSetup& setup, Rng& rng);

// Statistics of one band of the settings in one trial.
struct BandAccount {
  bool filled = false;     // by the chosen series
  int given_up = 0;        // targets given up because this was their first band without a scene
  BlockerCounts blockers;  // summed over all targets tried
  friend bool operator==(const BandAccount&, const BandAccount&) = default;
};

struct MadeSeries {
  CertifiedScene start;    // scene without blockers; `refused` covers all scenes tried
  OcclusionSeries series;  // first series that fills all bands, else the first that fills the most
  std::vector<BandAccount> bands;
  int targets_tried = 0;
};

// Makes the occlusion series of a trial. Targets are tried one after another, in random order,
// until one series fills all bands. If no target of a scene does, another scene is dropped.
// Scenes use the random streams "drop", "drop/scene_1", ..., and series use "occlude/SCENE/TARGET",
// all from (request.seed, request.bin_index). Targets are instances of `wanted` objects. The series
// is empty if no scene passes or no band can be filled; another trial may succeed. Throws
// InputError if no `wanted` object is dropped.
MadeSeries MakeOcclusionSeries(SceneRenderer& renderer, const SceneRequest& request,
                               const std::vector<ObjectId>& wanted, const OcclusionSetup& setup);

}  // namespace pickbed::sim
