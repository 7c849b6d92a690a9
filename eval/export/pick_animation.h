#pragma once

// Animations of executed grasps and stirs: a GLB file for 3D viewers and a GIF picture of each.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/trial/observer.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// One instant of a recorded pick.
struct MotionFrame {
  std::vector<Pose> X_WO;  // by scene.objects of the snapshot
  Pose X_WG = Pose::Identity();
  double opening_m = 0;
};

// The motion of one pick or stir.
struct PickMotion {
  Scene scene;  // before the motion
  std::vector<MotionFrame> frames;
  double frame_s = 0;                     // time between frames
  std::optional<AxisAlignedBox> table_W;  // on which the object was set down; none without a carry
};

// Returns the bytes of a GLB file with one animation. Nodes: "bin", "table", "INSTANCE OBJECT" and
// "hand I" for the boxes of the hand.
std::string PickGlb(const PickMotion& motion, const ObjectSet& objects, const Gripper& gripper);

// Size and speed of a GIF.
struct MovieOptions {
  int width_px = 480;
  int height_px = 360;
  int every = 2;     // frames of the motion per picture, 1 .. 100
  double speed = 2;  // 1 = real time, 0.1 .. 10
  int threads = 1;   // 1 .. 1024
  // Throws std::logic_error if a value is out of range.
  void Validate() const;
};

// Draws the picks of one bin as seen from above and beside it, as near as the whole pick permits.
// Keeps references to the objects and the gripper. The constructor throws std::logic_error if an
// option is out of range.
class PickMovie {
 public:
  PickMovie(const ObjectSet& objects, const Bin& bin, const Gripper& gripper,
            const MovieOptions& options = {});
  ~PickMovie();

  // Returns the bytes of a GIF.
  std::string Gif(const PickMotion& motion);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Returns the file name of an attempt's animation: attempt_NN_pick.glb.
std::string PickAnimationName(int attempt);

// Records the picks and stirs of a trial and writes attempt_NN_pick.glb for each, and
// attempt_NN_pick.gif on request. A GIF takes seconds, because each of its pictures is rendered.
class PickAnimation : public TrialObserver {
 public:
  // `attempt`: number of the only attempt to write, -1 = all in which the hand moved.
  PickAnimation(const std::filesystem::path& folder, bool with_gif, int attempt = -1);
  ~PickAnimation() override;

  void OnStage(TrialStage stage, const AttemptState& attempt) override;
  MotionListener ListenToMotion() override;
  int written() const { return written_; }  // number of animations

 private:
  std::filesystem::path folder_;
  bool with_gif_;
  int only_;
  int written_ = 0;
  bool wanted_ = false;  // the present attempt is to be written
  PickMotion motion_;
  ObjectSet objects_;                    // in their true sizes
  std::unique_ptr<PickMovie> movie_;     // made at the first pick
  const Gripper* movie_hand_ = nullptr;  // of movie_
};

}  // namespace pickbed::eval
