#include "sim/render/gl_drawer.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace pickbed::sim {
namespace {

// Returns whether one call can draw both. A draw with a scissor box needs its own call.
bool SameRun(const Draw& a, const Draw& b) {
  return !a.scissor && !b.scissor && a.mesh == b.mesh && a.level == b.level &&
         a.light_C == b.light_C;
}

}  // namespace

GlDrawer::GlDrawer(const GlFunctions& gl) : gl_(gl) {
  gl_.GenBuffers(1, &instance_buffer_);
  gl_.FrontFace(GL_CW);  // images are drawn upside down, see sim/render/shaders.h
}

int GlDrawer::AddMesh(const TriangleMesh& mesh, const std::vector<MeshLevel>& levels) {
  meshes_.push_back(UploadMesh(gl_, mesh, levels, instance_buffer_));
  return static_cast<int>(meshes_.size()) - 1;
}

void GlDrawer::UploadInstances(const std::vector<Draw>& draws) {
  attributes_.resize(draws.size());
  for (size_t i = 0; i < draws.size(); ++i) attributes_[i] = draws[i].attributes;
  gl_.BindBuffer(GL_ARRAY_BUFFER, instance_buffer_);
  gl_.BufferData(GL_ARRAY_BUFFER, attributes_.size() * sizeof(InstanceAttributes),
                 attributes_.data(), GL_STREAM_DRAW);
}

void GlDrawer::UseProgramFor(const GlMesh& mesh, const Draw& first, const DrawSetup& setup) {
  const bool color = setup.switches & kColorSwitch;
  unsigned switches = setup.switches;
  if (color && mesh.texture) {
    switches |= kTextureSwitch;
  } else if (color && mesh.colored_vertices) {
    switches |= kVertexColorSwitch;
  }
  if (mesh.flat && switches & (kColorSwitch | kNormalsSwitch)) switches |= kFlatSwitch;
  const GlProgram& program = programs_.Of(gl_, switches);
  gl_.UseProgram(program.program);
  if (!color) return;
  gl_.ActiveTexture(GL_TEXTURE0);
  if (mesh.texture) gl_.BindTexture(GL_TEXTURE_2D, mesh.texture);
  gl_.Uniform3f(program.color, mesh.base_color[0], mesh.base_color[1], mesh.base_color[2]);
  gl_.Uniform2f(program.ambient_diffuse, setup.ambient, setup.diffuse);
  gl_.Uniform3f(program.light_C, first.light_C[0], first.light_C[1], first.light_C[2]);
  if (!(switches & kShadowSwitch)) return;
  gl_.ActiveTexture(GL_TEXTURE1);
  gl_.BindTexture(GL_TEXTURE_2D, setup.shadow_map);
  gl_.UniformMatrix4fv(program.shadow_from_C, 1, GL_FALSE, setup.shadow_from_C.data());
  gl_.Uniform2f(program.shadow_blur, setup.shadow_blur[0], setup.shadow_blur[1]);
}

void GlDrawer::DrawAll(const std::vector<Draw>& draws, const DrawSetup& setup) {
  if (draws.empty()) return;
  UploadInstances(draws);
  for (size_t begin = 0, end = 0; begin < draws.size(); begin = end) {
    const Draw& first = draws[begin];
    for (end = begin + 1; end < draws.size() && SameRun(first, draws[end]);) ++end;
    if (first.scissor) {
      gl_.Enable(GL_SCISSOR_TEST);
      const auto& [x, y, width, height] = *first.scissor;
      gl_.Scissor(x, y, width, height);
    } else {
      gl_.Disable(GL_SCISSOR_TEST);
    }
    const GlMesh& mesh = meshes_[first.mesh];
    const GlMeshLevel& level = mesh.levels[first.level];
    UseProgramFor(mesh, first, setup);
    if (mesh.cull_back) {
      gl_.Enable(GL_CULL_FACE);
    } else {
      gl_.Disable(GL_CULL_FACE);
    }
    gl_.BindVertexArray(level.vertex_array);
    BindInstances(gl_, instance_buffer_, begin);
    gl_.DrawElementsInstanced(GL_TRIANGLES, level.index_count, level.index_type, nullptr,
                              static_cast<GLsizei>(end - begin));
  }
}

void GlDrawer::DeleteAll() {
  for (GlMesh& mesh : meshes_) DeleteMesh(gl_, mesh);
  meshes_.clear();
  programs_.DeleteAll(gl_);
  gl_.DeleteBuffers(1, &instance_buffer_);
}

void SortNearFirst(std::vector<Draw>& draws) {
  std::map<std::pair<int, int>, std::pair<double, int>> sums;
  for (const Draw& draw : draws) {
    auto& [sum, count] = sums[{draw.mesh, draw.level}];
    sum += draw.near_m;
    ++count;
  }
  const auto mean = [&](const Draw& draw) {
    const auto& [sum, count] = sums.at({draw.mesh, draw.level});
    return sum / count;
  };
  std::stable_sort(draws.begin(), draws.end(), [&](const Draw& a, const Draw& b) {
    const double mean_a = mean(a), mean_b = mean(b);
    if (mean_a != mean_b) return mean_a < mean_b;
    return std::tie(a.mesh, a.level, a.near_m) < std::tie(b.mesh, b.level, b.near_m);
  });
}

// Computes OpenGL clip coordinates. A pixel center has integer coordinates in the camera model and
// half-integer ones in OpenGL: u + 0.5 = (clip x / clip w + 1) / 2 * width.
InstanceAttributes AttributesOf(const Pose& X_CO, const RenderInstance& instance,
                                const CameraIntrinsics& k, const DepthRange& range,
                                const Eigen::Vector2i& corner, int viewport_width,
                                int viewport_height) {
  InstanceAttributes out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      out.X_CO_rows[4 * row + column] = static_cast<float>(X_CO(row, column));
    }
  }
  out.xy_projection = {static_cast<float>(2 * k.fx() / viewport_width),
                       static_cast<float>(2 * (k.cx() + corner.x() + 0.5) / viewport_width - 1),
                       static_cast<float>(2 * k.fy() / viewport_height),
                       static_cast<float>(2 * (k.cy() + corner.y() + 0.5) / viewport_height - 1)};
  const double depth = range.far_m - range.near_m;
  out.z_projection = {static_cast<float>((range.far_m + range.near_m) / depth),
                      static_cast<float>(-2 * range.far_m * range.near_m / depth)};
  const Material& m = instance.material;
  out.tint_gloss = {static_cast<float>(m.tint.x()), static_cast<float>(m.tint.y()),
                    static_cast<float>(m.tint.z()), static_cast<float>(m.gloss)};
  out.grain = {static_cast<float>(m.grain), static_cast<float>(m.grain_cells_pm)};
  out.id = instance.id;
  return out;
}

}  // namespace pickbed::sim
