#include "perception/verify/depth_evidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scenes/camera/footprint.h"
#include "scenes/geometry/mesh_levels.h"
#include "scenes/mesh_io/mesh_checks.h"

namespace pickbed::perception {
namespace {

constexpr int kAgreementSteps = 64;

// Returns the mesh itself if it has few triangles, else its coarsest level that is accurate enough
// for a depth sensor. Scans with 100,000 triangles take a hundred times as long to draw.
TriangleMesh DrawnMesh(const ObjectModel& model) {
  constexpr size_t kFewTriangles = 3000;
  constexpr double kDeviationDiameters = 0.002;
  if (model.mesh_O.triangles.size() <= kFewTriangles) return model.mesh_O;
  TriangleMesh coarsest = model.mesh_O;
  for (MeshLevel& level : MakeMeshLevels(model.mesh_O)) {
    if (level.deviation_m > kDeviationDiameters * model.diameter_m) break;
    coarsest = std::move(level.mesh);
  }
  return coarsest;
}

// Image region that a footprint may touch; empty outside the image.
ImageBox BoxOf(const Footprint& footprint, const CameraIntrinsics& k) {
  if (!footprint.in_front || !footprint.Overlaps(k)) return {};
  DrawnBox drawn(k);
  drawn.Include(footprint);
  return drawn.box();
}

// Rendered surface at one pixel.
struct Surface {
  float z_m = 0;
  Eigen::Vector3f normal_C;  // unit, towards the camera
  float along_normal = 0;    // metres along the normal per metre of depth; negative
};

// The four functions of a face are evaluated at once: the inverse depth, which is not used here,
// and the normal.
Surface SurfaceAt(const RasterFace& face, int x, int y, float z_m, const Eigen::Vector3f& ray) {
  using Functions = Eigen::Map<const Eigen::Vector4f>;
  Eigen::Vector4f at = Functions(face.at_origin.data()) +
                       static_cast<float>(x) * Functions(face.by_column.data()) +
                       static_cast<float>(y) * Functions(face.by_row.data());
  const float squared = at.tail<3>().squaredNorm();
  if (squared > 0) at /= std::sqrt(squared);
  const Eigen::Vector3f n = at.tail<3>();
  const float towards = n.dot(ray);
  if (towards > 0) return {z_m, -n, -towards};
  return {z_m, n, towards};
}

// Samples left, right, above and below an agreeing pixel (x, y) of the drawn box. `at` is the
// rendered surface there.
class OutlineCheck {
 public:
  OutlineCheck(const OrganizedCloud& cloud, const FaceRaster& drawn,
               const DepthEvidenceOptions& options, float sigma_m, float depth_band_m,
               PoseSupportMeasure* support)
      : cloud_(cloud),
        drawn_(drawn),
        reach_px_(options.beyond_px),
        band_m_(static_cast<float>(options.continuing_sigmas) * sigma_m),
        depth_band_m_(depth_band_m),
        min_cos_(static_cast<float>(options.continuing_min_cos)),
        support_(support) {}

  void operator()(int x, int y, const RasterFace& face, const Surface& at, DepthEvidence& e) const {
    bool at_outline = false, seen = false;
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const Sample sample = Beyond(x + reach_px_ * dx, y + reach_px_ * dy, face, at, e);
      at_outline |= sample != Sample::kDrawn;
      seen |= sample == Sample::kFarther;
    }
    if (support_ && at_outline) support_->AddOutline(PointAt(x, y, at.z_m), Across(x, y), seen);
  }

 private:
  bool IsDrawn(int x, int y) const {
    return x >= 0 && y >= 0 && x < drawn_.box().width && y < drawn_.box().height &&
           drawn_.InverseDepths(y)[x] > 0;
  }

  // Unit vector across the outline near a drawn pixel, outwards and parallel to the image: away
  // from the mean of the drawn pixels around it.
  Eigen::Vector3f Across(int x, int y) const {
    int sum_x = 0, sum_y = 0;
    for (int dy = -reach_px_; dy <= reach_px_; ++dy) {
      for (int dx = -reach_px_; dx <= reach_px_; ++dx) {
        if (!IsDrawn(x + dx, y + dy)) continue;
        sum_x += dx;
        sum_y += dy;
      }
    }
    Eigen::Vector3f across_C(static_cast<float>(-sum_x), static_cast<float>(-sum_y), 0);
    if (!across_C.isZero(0)) across_C.normalize();
    return across_C;
  }

  Eigen::Vector3f PointAt(int x, int y, float z_m) const {
    const CameraIntrinsics& k = cloud_.intrinsics;
    return z_m * Eigen::Vector3f(static_cast<float>((drawn_.box().x + x - k.cx()) / k.fx()),
                                 static_cast<float>((drawn_.box().y + y - k.cy()) / k.fy()), 1);
  }

  enum class Sample { kDrawn, kUnknown, kHidden, kContinuing, kFarther };
  Sample Beyond(int x, int y, const RasterFace& face, const Surface& at, DepthEvidence& e) const {
    if (IsDrawn(x, y)) return Sample::kDrawn;
    const int column = drawn_.box().x + x, row = drawn_.box().y + y;
    const CameraIntrinsics& k = cloud_.intrinsics;
    if (column < 0 || row < 0 || column >= k.width() || row >= k.height()) return Sample::kUnknown;
    const size_t pixel = static_cast<size_t>(k.width()) * row + column;
    const float seen_m = cloud_.depth_m.data()[pixel];
    const float inverse = face.at_origin[0] + static_cast<float>(x) * face.by_column[0] +
                          static_cast<float>(y) * face.by_row[0];
    if (!(seen_m > 0) || !(inverse > 0)) return Sample::kUnknown;
    if (support_) support_->AddOther(cloud_.points_C[pixel]);
    const float behind_m = seen_m - 1 / inverse;
    if (behind_m < -depth_band_m_) return Sample::kHidden;
    ++e.beyond;
    const Eigen::Vector3f& normal_C = cloud_.normals_C[pixel];
    const bool near_plane = std::abs(at.along_normal * behind_m) < band_m_;
    if (near_plane && cloud_.foreground.data()[pixel] && normal_C.dot(at.normal_C) > min_cos_) {
      ++e.continuing;
      return Sample::kContinuing;
    }
    return behind_m > depth_band_m_ ? Sample::kFarther : Sample::kUnknown;
  }

  const OrganizedCloud& cloud_;
  const FaceRaster& drawn_;
  int reach_px_;
  float band_m_, depth_band_m_, min_cos_;
  PoseSupportMeasure* support_;
};

// Scales the counts by the stride to all pixels and computes log_ratio. `agreement` is the sum over
// the agreeing pixels.
void Weigh(const DepthEvidenceOptions& options, double agreement, int stride, DepthEvidence& e) {
  const double weight = static_cast<double>(stride) * stride;
  for (double* count : {&e.covered, &e.agreeing, &e.hidden, &e.violated, &e.wrong_normal, &e.beyond,
                        &e.continuing}) {
    *count *= weight;
  }
  e.log_ratio = weight * agreement - options.violated_cost * e.violated -
                options.hidden_cost * e.hidden - options.wrong_normal_cost * e.wrong_normal -
                options.continuing_cost * e.continuing;
}

}  // namespace

void DepthEvidenceOptions::Visit(SettingsVisitor& v) {
  const Range sigmas{0.1, 100}, cosine{-1, 1}, cost{0, 1000};
  v.Real("sigma_m", sigma_m, {1e-6, 1}, "noise along the normal, m, up to 1 m");
  v.Real("max_sigmas", max_sigmas, sigmas, "half width of the surface band, sigmas");
  v.Real("max_depth_bands", max_depth_bands, {1, 1000}, "maximum distance along the ray, bands");
  v.Real("min_normal_cos", min_normal_cos, cosine,
         "minimum cosine between the normals of model and reading");
  v.Real("occlusion", occlusion, {0, 1}, "prior probability that a pixel is occluded");
  v.Real("outlier", outlier, {1e-9, 1}, "probability of a meaningless reading");
  v.Real("violated_cost", violated_cost, cost, "cost of a reading behind the surface, nats");
  v.Real("hidden_cost", hidden_cost, cost, "cost of a reading in front of the surface, nats");
  v.Real("wrong_normal_cost", wrong_normal_cost, cost,
         "cost of a reading on the surface with another normal, nats");
  v.Real("continuing_cost", continuing_cost, cost,
         "cost of a sample beyond the outline where the surface continues, nats");
  v.Integer("beyond_px", beyond_px, {1, 1000}, "distance of these samples, px");
  v.Real("continuing_sigmas", continuing_sigmas, sigmas,
         "distance to the plane of the agreeing pixel up to which the surface continues, sigmas");
  v.Real("continuing_min_cos", continuing_min_cos, cosine,
         "minimum cosine between the normals where the surface continues");
  v.Integer("max_pixels", max_pixels, {1, 10000000}, "approximate number of pixels evaluated");
}

DepthEvidenceOf::DepthEvidenceOf(const ObjectModel& model, const DepthEvidenceOptions& options)
    : options_(options),
      mesh_(DrawnMesh(model)),
      bounds_O_(MeshBounds(model.mesh_O)),
      diameter_m_(model.diameter_m) {
  CheckSettings("DepthEvidenceOptions", options);
  const MeshReport report = InspectMesh(model.mesh_O);
  cull_back_ = report.watertight() && report.volume_m3 > 0;
  const double max_squared = options.max_sigmas * options.max_sigmas;
  for (int i = 0; i <= kAgreementSteps; ++i) {
    agreement_.push_back(static_cast<float>(Agreement(max_squared * i / kAgreementSteps)));
  }
}

// Readings that are not on the object are assumed uniform over a depth range of its diameter.
double DepthEvidenceOf::Agreement(double squared_sigmas) const {
  const double peak = diameter_m_ / (std::sqrt(2 * std::numbers::pi) * options_.sigma_m);
  return std::log((1 - options_.occlusion) * peak * std::exp(-0.5 * squared_sigmas) +
                  options_.occlusion + options_.outlier);
}

DepthEvidence DepthEvidenceOf::operator()(const OrganizedCloud& cloud, const Pose& X_CO,
                                          EvidenceScratch& scratch, std::optional<int> max_pixels,
                                          PoseSupportMeasure* support) const {
  DepthEvidence e;
  const CameraIntrinsics& k = cloud.intrinsics;
  const ImageBox box = BoxOf(FootprintOf(bounds_O_, X_CO, k), k);
  if (box.width <= 0 || box.height <= 0) return e;
  scratch.Begin(k, box);
  scratch.Draw(mesh_, X_CO, cull_back_);
  const double z_m = (X_CO * bounds_O_.center()).z();
  const float sigma_m =
      static_cast<float>(options_.sigma_m * cloud.error_scale * std::max(1.0, z_m * z_m));
  const float band_m = static_cast<float>(options_.max_sigmas) * sigma_m;
  const float depth_band_m = static_cast<float>(options_.max_depth_bands) * band_m;
  const float min_cos = static_cast<float>(options_.min_normal_cos);
  const float per_step =
      kAgreementSteps / static_cast<float>(options_.max_sigmas * options_.max_sigmas);
  const double pixels = static_cast<double>(box.width) * box.height;
  const int stride =
      std::max(1, static_cast<int>(std::sqrt(pixels / max_pixels.value_or(options_.max_pixels))));
  const OutlineCheck check_beyond(cloud, scratch, options_, sigma_m, depth_band_m, support);
  if (support) {
    support->Begin((X_CO * bounds_O_.center()).cast<float>(), static_cast<float>(diameter_m_ / 2),
                   2 * sigma_m);
  }
  double agreement = 0;
  for (int y = stride / 2; y < box.height; y += stride) {
    const auto [begin, end] = scratch.Touched(y);
    const float* inverse = scratch.InverseDepths(y);
    const int* face_at = scratch.FacesAt(y);
    const size_t row = static_cast<size_t>(k.width()) * (box.y + y) + box.x;
    const float ray_y = static_cast<float>((box.y + y - k.cy()) / k.fy());
    for (int x = begin + (stride / 2 + stride - begin % stride) % stride; x < end; x += stride) {
      if (!(inverse[x] > 0)) continue;
      ++e.covered;
      if (support) support->AddCovered();
      const float seen_m = cloud.depth_m.data()[row + x];
      if (!(seen_m > 0)) continue;
      const Eigen::Vector3f ray(static_cast<float>((box.x + x - k.cx()) / k.fx()), ray_y, 1);
      const float drawn_m = 1 / inverse[x];
      const float behind_m = seen_m - drawn_m;
      const auto count_off_surface = [&] {
        ++(behind_m > 0 ? e.violated : e.hidden);
        if (support && behind_m < 0) support->AddOther(seen_m * ray);
      };
      if (std::abs(behind_m) >= depth_band_m) {
        count_off_surface();
        continue;
      }
      const RasterFace& face = scratch.faces()[face_at[x]];
      const Surface at = SurfaceAt(face, x, y, drawn_m, ray);
      const float off_m = at.along_normal * behind_m;
      if (std::abs(off_m) >= band_m) {
        count_off_surface();
        continue;
      }
      if (!cloud.foreground.data()[row + x]) continue;
      const Eigen::Vector3f& normal_C = cloud.normals_C[row + x];
      if (!normal_C.isZero(0) && normal_C.dot(at.normal_C) < min_cos) {
        ++e.wrong_normal;
        continue;
      }
      ++e.agreeing;
      const float sigmas = off_m / sigma_m;
      agreement += agreement_[static_cast<int>(sigmas * sigmas * per_step)];
      if (support) support->AddAgreeing(at.z_m * ray, at.normal_C);
      check_beyond(x, y, face, at, e);
    }
  }
  scratch.Clean();
  Weigh(options_, agreement, stride, e);
  return e;
}

}  // namespace pickbed::perception
