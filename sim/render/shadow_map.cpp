#include "sim/render/shadow_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/camera/footprint.h"
#include "sim/render/gl_drawer.h"

namespace pickbed::sim {
namespace {

constexpr int kSide_px = 1024;
constexpr double kMaxTangent = 4;  // of half the map's field of view, for a light inside the scene

// A sphere around the bounding boxes of all instances.
struct Sphere {
  Eigen::Vector3d center_W;
  double radius_m;
};

Sphere Enclose(const GlDrawer& drawer, std::span<const RenderInstance> instances) {
  Eigen::AlignedBox3d box;
  for (const RenderInstance& instance : instances) {
    const Bounds& bounds_O = drawer.Mesh(instance.mesh).bounds_O;
    const Eigen::AlignedBox3d box_O(bounds_O.min, bounds_O.max);
    box.extend(box_O.transformed(instance.X_WO));
  }
  return {box.center(), 0.5 * box.diagonal().norm()};
}

Pose LampPose(const Eigen::Vector3d& position_W, const Eigen::Vector3d& target_W) {
  const Eigen::Vector3d z = (target_W - position_W).normalized();
  const Eigen::Vector3d up =
      std::abs(z.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  return LookAt(position_W, target_W, up);
}

}  // namespace

bool ShadowMap::Draw(const GlFunctions& gl, GlDrawer& drawer,
                     std::span<const RenderInstance> instances, const Light& light) {
  if (instances.empty()) return false;
  const Sphere sphere = Enclose(drawer, instances);
  const double distance_m = (sphere.center_W - light.position_W).norm();
  if (distance_m < kNearestDrawn_m) return false;
  const double r = sphere.radius_m;
  const double tangent = distance_m > r
                             ? std::min(kMaxTangent, r / std::sqrt(distance_m * distance_m - r * r))
                             : kMaxTangent;
  X_WL_ = LampPose(light.position_W, sphere.center_W);
  focal_ = 1 / tangent;
  near_m_ = std::max(kNearestDrawn_m, 0.999 * (distance_m - r));
  far_m_ = 1.001 * (distance_m + r);
  const double texel_m = 2 * tangent * distance_m / kSide_px;
  blur_ = std::max(light.shadow_softness_m, texel_m) / texel_m / kSide_px;
  offset_m_ = std::max(light.shadow_softness_m, texel_m) + texel_m;

  if (!framebuffer_) {
    gl.GenFramebuffers(1, &framebuffer_);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl.GenTextures(1, &texture_);
    gl.BindTexture(GL_TEXTURE_2D, texture_);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, kSide_px, kSide_px, 0,
                  GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
  }
  const double focal_px = 0.5 * kSide_px * focal_, center_px = 0.5 * (kSide_px - 1);
  const CameraIntrinsics k{kSide_px, kSide_px, focal_px, focal_px, center_px, center_px};
  const Pose X_LW = X_WL_.inverse();
  std::vector<sim::Draw> draws;
  for (const RenderInstance& instance : instances) {
    sim::Draw draw;
    draw.mesh = instance.mesh;
    draw.attributes = AttributesOf(X_LW * instance.X_WO, instance, k, {near_m_, far_m_},
                                   Eigen::Vector2i::Zero(), kSide_px, kSide_px);
    draws.push_back(draw);
  }
  SortNearFirst(draws);
  constexpr GLenum kNone = GL_NONE;
  constexpr float kFar = 1;
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl.DrawBuffers(1, &kNone);
  gl.Viewport(0, 0, kSide_px, kSide_px);
  gl.Disable(GL_SCISSOR_TEST);
  gl.Enable(GL_DEPTH_TEST);
  gl.ClearBufferfv(GL_DEPTH, 0, &kFar);
  DrawSetup setup;
  setup.switches = kShadowMapSwitch;
  drawer.DrawAll(draws, setup);
  return true;
}

void ShadowMap::AddTo(DrawSetup& setup, const Pose& X_CW) const {
  const double depth = far_m_ - near_m_;
  Eigen::Matrix4d clip_from_L = Eigen::Matrix4d::Zero();
  clip_from_L(0, 0) = clip_from_L(1, 1) = focal_;
  clip_from_L(2, 2) = (far_m_ + near_m_) / depth;
  clip_from_L(2, 3) = -2 * far_m_ * near_m_ / depth;
  clip_from_L(3, 2) = 1;
  Eigen::Matrix4d texture_from_clip = 0.5 * Eigen::Matrix4d::Identity();
  texture_from_clip.col(3) << 0.5, 0.5, 0.5, 1;
  const Eigen::Matrix4f m =
      (texture_from_clip * clip_from_L * (X_WL_.inverse() * X_CW.inverse()).matrix()).cast<float>();
  std::copy_n(m.data(), 16, setup.shadow_from_C.data());
  setup.shadow_blur = {static_cast<float>(blur_), static_cast<float>(offset_m_)};
  setup.shadow_map = texture_;
  setup.switches |= kShadowSwitch;
}

void ShadowMap::Delete(const GlFunctions& gl) {
  if (framebuffer_) gl.DeleteFramebuffers(1, &framebuffer_);
  if (texture_) gl.DeleteTextures(1, &texture_);
  framebuffer_ = texture_ = 0;
}

}  // namespace pickbed::sim
