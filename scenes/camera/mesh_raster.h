#pragma once

// Software rasterizer: finds the nearest face of a mesh and its depth for each pixel of an image
// region. For the small triangles of object meshes it is several times as fast as llvmpipe.
//
// Outlines are rounded to 1/256 of a pixel. A pixel on an edge belongs to the face below it or to
// its right. Other values of a pixel are computed from the face's attributes divided by depth.
// These are linear in the image (Heckbert and Moreton, "Interpolation for Polygon Texture Mapping
// and Shading", 1991).

#include <array>
#include <vector>

#include "scenes/camera/camera.h"
#include "scenes/camera/mesh_raster_rows.h"
#include "scenes/geometry/pose.h"
#include "scenes/geometry/triangle_mesh.h"
#include "scenes/image/image.h"

namespace pickbed::scenes {

// A mesh with one array for each coordinate.
struct RasterMesh {
  explicit RasterMesh(const TriangleMesh& mesh);
  std::array<std::vector<float>, 3> position_O;  // m
  std::array<std::vector<float>, 3> normal_O;    // unit; of vertices, or of triangles if flat
  std::vector<std::array<int, 3>> triangles;
  bool flat = false;
};

// Draws meshes into one picture at a time: Begin(), Draw() for each mesh, read the rows, Clean().
class FaceRaster {
 public:
  // Starts a picture of region `box` of the camera's image. Memory is kept for the next picture.
  void Begin(const CameraIntrinsics& camera, const ImageBox& box);

  // Draws a mesh. The complete mesh must be in front of the camera. `attributes` (red, green, blue
  // and id) is stored with its faces. `cull_back` skips faces that point away from the camera. It
  // is allowed for a closed mesh with its faces outwards.
  void Draw(const RasterMesh& mesh, const Pose& X_CO, bool cull_back,
            const std::array<float, 4>& attributes = {});

  // State of the current picture. Rows and columns are counted in the box. A row has kRasterPadding
  // more pixels than the box; they have no valid content.
  const ImageBox& box() const { return box_; }
  int pitch() const { return pitch_; }
  const std::array<int, 2>& Touched(int y) const { return touched_[y]; }  // first column, past last
  // 1/m of the nearest face; 0 = no face.
  const float* InverseDepths(int y) const { return inverse_depth_.data() + Row(y); }
  // Index into faces(); only valid where the inverse depth is not 0.
  const int* FacesAt(int y) const { return face_at_.data() + Row(y); }
  const RasterFace* faces() const { return faces_.data(); }

  // Ends the picture and clears its pixels. It must be called before the next Begin().
  void Clean();

 private:
  void Project(const RasterMesh& mesh, const Pose& X_CO);
  size_t Row(int y) const { return static_cast<size_t>(pitch_) * y; }

  CameraIntrinsics camera_;
  ImageBox box_;
  int pitch_ = 0;                            // px per row of inverse_depth_ and face_at_
  std::vector<float> inverse_depth_;         // 1/m of the nearest face, 0 = no face
  std::vector<int> face_at_;                 // index of the nearest face
  std::vector<std::array<int, 2>> touched_;  // for each row
  std::vector<float> screen_x_, screen_y_;   // of vertices, px in the box
  std::vector<int> snapped_x_, snapped_y_;   // of vertices, 1/256 px
  std::vector<float> over_depth_;            // of vertices: 1 / z, normal / z
  std::vector<float> face_normals_;          // of the faces of a flat mesh: 1, normal
  std::vector<RasterFace> faces_;
  int face_count_ = 0;
};

}  // namespace pickbed::scenes
