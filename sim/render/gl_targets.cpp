#include "sim/render/gl_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace pickbed::sim {
namespace {

// Limit of all cached targets together. A pixel has 16 bytes or more.
constexpr size_t kKeptPixels = size_t{8} << 20;

struct Attachment {
  GLenum point, format;
};

std::vector<Attachment> AttachmentsOf(GlTargetKind kind) {
  if (kind == GlTargetKind::kCoverage) return {{AttachmentOf(kDepthOutput), GL_R8}};
  std::vector<Attachment> out = {{AttachmentOf(kDepthOutput), GL_R32F},
                                 {AttachmentOf(kIdOutput), GL_R32UI},
                                 {AttachmentOf(kColorOutput), GL_RGBA8},
                                 {GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F}};
  if (kind == GlTargetKind::kImageAndExtras) {
    out.push_back({AttachmentOf(kNormalOutput), GL_RGBA32F});
    out.push_back({AttachmentOf(kCoordinateOutput), GL_RGBA32F});
  }
  return out;
}

void DeleteTarget(const GlFunctions& gl, GlTarget& target) {
  gl.DeleteFramebuffers(1, &target.framebuffer);
  gl.DeleteRenderbuffers(static_cast<GLsizei>(target.renderbuffers.size()),
                         target.renderbuffers.data());
}

GlTarget MakeTarget(const GlFunctions& gl, GlTargetKind kind, int width, int height) {
  const std::vector<Attachment> attachments = AttachmentsOf(kind);
  GlTarget target{kind, width, height, 0, std::vector<GLuint>(attachments.size())};
  gl.GenFramebuffers(1, &target.framebuffer);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  gl.GenRenderbuffers(static_cast<GLsizei>(attachments.size()), target.renderbuffers.data());
  for (size_t i = 0; i < attachments.size(); ++i) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, target.renderbuffers[i]);
    gl.RenderbufferStorage(GL_RENDERBUFFER, attachments[i].format, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachments[i].point, GL_RENDERBUFFER,
                               target.renderbuffers[i]);
  }
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    DeleteTarget(gl, target);
    throw std::runtime_error(fmt::format("no framebuffer of {} x {} pixels", width, height));
  }
  return target;
}

}  // namespace

const GlTarget& GlTargets::Of(const GlFunctions& gl, GlTargetKind kind, int width, int height) {
  const auto found = std::find_if(targets_.begin(), targets_.end(), [&](const GlTarget& t) {
    return t.kind == kind && t.width == width && t.height == height;
  });
  if (found != targets_.end()) {
    std::rotate(found, found + 1, targets_.end());
    return targets_.back();
  }
  size_t pixels = static_cast<size_t>(width) * height;
  for (const GlTarget& t : targets_) pixels += static_cast<size_t>(t.width) * t.height;
  while (!targets_.empty() && pixels > kKeptPixels) {
    pixels -= static_cast<size_t>(targets_.front().width) * targets_.front().height;
    DeleteTarget(gl, targets_.front());
    targets_.erase(targets_.begin());
  }
  targets_.push_back(MakeTarget(gl, kind, width, height));
  return targets_.back();
}

void GlTargets::DeleteAll(const GlFunctions& gl) {
  for (GlTarget& target : targets_) DeleteTarget(gl, target);
  targets_.clear();
}

void BeginTarget(const GlFunctions& gl, const GlTarget& target, GlOutputs outputs) {
  constexpr float kZero[4] = {0, 0, 0, 0};
  constexpr GLuint kZeroId[4] = {0, 0, 0, 0};
  constexpr float kFar = 1;
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  gl.Disable(GL_SCISSOR_TEST);
  std::array<GLenum, kOutputCount> drawn{};
  int count = 0;
  for (unsigned i = 0; i < kOutputCount; ++i) {
    const bool is_drawn = outputs & (1u << i);
    drawn[i] = is_drawn ? GL_COLOR_ATTACHMENT0 + i : GL_NONE;
    if (is_drawn) count = static_cast<int>(i) + 1;
  }
  gl.DrawBuffers(count, drawn.data());
  for (int i = 0; i < count; ++i) {
    if (drawn[i] == GL_NONE) continue;
    if (i == kIdOutput) {
      gl.ClearBufferuiv(GL_COLOR, i, kZeroId);
    } else {
      gl.ClearBufferfv(GL_COLOR, i, kZero);
    }
  }
  if (target.kind == GlTargetKind::kCoverage) {
    gl.Disable(GL_DEPTH_TEST);
  } else {
    gl.Enable(GL_DEPTH_TEST);
    gl.ClearBufferfv(GL_DEPTH, 0, &kFar);
  }
}

}  // namespace pickbed::sim
