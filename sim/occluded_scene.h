#pragma once

// One target seen with ever less of it in view: blockers are dropped near the line of sight, one by
// one. Of the scenes in which the target's visible fraction falls into a band the one is kept that
// comes nearest to a fraction drawn evenly over the band, since the first leans to its upper end.
//
// While a blocker settles the target and all other parts are static, so that the target's pose is
// the same bits in all scenes of a series. Then the whole scene has to pass the certificate with
// all parts awake, or the blocker is taken back.

#include <vector>

#include "scenes/camera.h"
#include "scenes/occlusion_spec.h"
#include "scenes/random.h"
#include "sim/renderer.h"
#include "sim/scene_rest.h"

namespace pickbed {

struct OcclusionSetup {
  const ObjectSet& objects;  // with convex pieces
  std::vector<int> counts;   // of each object in the scenario: blockers are drawn in proportion
  Camera camera;
  DropOptions drop;
  OcclusionSpec spec;
};

// What became of the blockers that were dropped while one band was the next to be filled.
struct BlockerCounts {
  int dropped = 0;
  int kept = 0;
  int refused = 0;  // the scene failed its certificate, or the blocker did not settle in the bin
  int jumped = 0;   // hid so much that the band was left out
  int useless = 0;  // hid less than OcclusionSpec::least_hidden
  void Add(const BlockerCounts& other);
  friend bool operator==(const BlockerCounts&, const BlockerCounts&) = default;
};

struct OccludedScene {
  int band = 0;
  double visible_fraction = 0;  // of the target
  int blockers = 0;             // the last so many of scene.objects
  Scene scene;
  SceneCertificate certificate;
};

struct OcclusionSeries {
  int target = -1;                      // instance
  std::vector<OccludedScene> scenes;    // one a band that was filled, the most visible first
  std::vector<BlockerCounts> blockers;  // by band of the settings
};

// A scene as it is before blockers come.
struct SettledScene {
  const Scene& scene;
  const SceneCertificate& certificate;
};

// Shares in view, of each scene.objects[i].
std::vector<double> VisibleFractionsIn(SceneRenderer& renderer, const Scene& scene,
                                       const Camera& camera);

// Instances, among those of objects that are `wanted`, of which enough is in view to begin with:
// from the most visible band's lower end on. In the order of the scene.
std::vector<int> PossibleTargets(SceneRenderer& renderer, const Scene& scene,
                                 const std::vector<int>& wanted, const OcclusionSetup& setup);

// Ends when all bands are filled, when the blockers tried for one band or those that lie in the
// scene are as many as the settings allow. A function of its arguments alone. The target's instance
// must be in the scene (std::logic_error).
OcclusionSeries OccludeTarget(SceneRenderer& renderer, const SettledScene& start, int target,
                              const OcclusionSetup& setup, Rng& rng);

}  // namespace pickbed
