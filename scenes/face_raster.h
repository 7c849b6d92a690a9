#pragma once

// Which face of a mesh is nearest in each pixel of a part of an image, and how far away it is. For
// the triangles of few pixels that parts are made of it is several times as fast as llvmpipe.
// Outlines are rounded to 1/256 of a pixel; a pixel on an edge belongs to the face below it or to
// its right. What is to be known of a pixel then follows from the face's attributes over depth,
// which are linear in the image (Heckbert and Moreton, "Interpolation for Polygon Texture Mapping
// and Shading", 1991).

#include <array>
#include <vector>

#include "scenes/camera.h"
#include "scenes/image.h"
#include "scenes/pose.h"
#include "scenes/raster_faces.h"
#include "scenes/triangle_mesh.h"

namespace pickbed {

// A mesh, coordinate by coordinate.
struct RasterMesh {
  explicit RasterMesh(const TriangleMesh& mesh);
  std::array<std::vector<float>, 3> position_O;  // m
  std::array<std::vector<float>, 3> normal_O;    // of vertices, or of triangles if flat
  std::vector<std::array<int, 3>> triangles;
  bool flat = false;
};

class FaceRaster {
 public:
  // Starts a picture of a part of the camera's image. Memory is kept from picture to picture.
  void Begin(const CameraIntrinsics& camera, const ImageBox& box);

  // All of the mesh must be in front of the camera. `look` stays with its faces; `cull_back` leaves
  // out those that turn away, of a mesh that is closed and faces outward.
  void Draw(const RasterMesh& mesh, const Pose& X_CO, bool cull_back,
            const std::array<float, 4>& look = {});

  // Of the picture under way. Rows and columns are the box's; a row has kRasterPadding pixels more
  // than the box, which hold nothing.
  const ImageBox& box() const { return box_; }
  int pitch() const { return pitch_; }
  const std::array<int, 2>& Touched(int y) const { return touched_[y]; }  // first column, past last
  const float* InverseDepths(int y) const { return inverse_depth_.data() + Row(y); }  // 1/m, 0 = no
  const int* FacesAt(int y) const { return face_at_.data() + Row(y); }  // where depth is not 0
  const RasterFace* faces() const { return faces_.data(); }

  // Ends the picture, which must be done before the next Begin.
  void Clean();

 private:
  void Project(const RasterMesh& mesh, const Pose& X_CO);
  size_t Row(int y) const { return static_cast<size_t>(pitch_) * y; }

  CameraIntrinsics camera_;
  ImageBox box_;
  int pitch_ = 0;                            // of the two below
  std::vector<float> inverse_depth_;         // 1/m of what is nearest, 0 = nothing
  std::vector<int> face_at_;                 // which face that is
  std::vector<std::array<int, 2>> touched_;  // of each row
  std::vector<float> screen_x_, screen_y_;   // of vertices, px of the box
  std::vector<int> snapped_x_, snapped_y_;   // 1/256 px
  std::vector<float> over_depth_;            // of vertices: 1 / z, normal / z
  std::vector<float> face_normals_;          // of a flat mesh: 1, normal
  std::vector<RasterFace> faces_;
  int face_count_ = 0;
};

}  // namespace pickbed
