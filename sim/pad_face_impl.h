#pragma once

// Private to sim's physics: the whole face on which a pad lies, as contacts of one step.
//
// Bullet finds one point of contact of two pieces in a step, which may be any of two faces that lie
// flat on each other, and collects up to four over the steps that follow. Fingers that close on a
// part would meanwhile press on it at two places that do not stand opposite each other: it was
// turned out of the hand, or the pads sank into it by millimetres, by the luck of the first steps.

#include <btBulletDynamicsCommon.h>

namespace pickbed {

// True for a finger of a jaw: its faces across x are pads.
bool IsPad(const btCollisionObjectWrapper& body);

// Adds the corners of that face of `hull` which lies on the pad, as far as it lies within the pad's
// edges, to the contacts of the two; `axis_W` is along the way between them, of any length. Nothing
// when they don't meet face to face. In Bullet's units.
void AddPadFace(const btCollisionObjectWrapper& pad, const btCollisionObjectWrapper& hull,
                bool pad_is_first, const btVector3& axis_W, btManifoldResult& result);

}  // namespace pickbed
