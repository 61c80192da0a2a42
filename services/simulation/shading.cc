#include "services/simulation/shading.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "services/simulation/parallel_rows.h"
#include "services/simulation/surface_patterns.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

constexpr size_t kMaterials = static_cast<size_t>(Material::kSky) + 1;

// A seen face as functions of the pixel p = (x, y, 1): along its ray of depth 1, `u_slope . p` is
// the change of u a metre of depth, and `nearness . p` is 1 / depth.
struct SeenSurface {
  Vector3f u_slope;
  Vector3f v_slope;
  Vector3f nearness;
  float u_at_eye = 0;
  float v_at_eye = 0;
  float light = 0;  // What falls on it times its tone.
  uint32_t seed = 0;
  Material material = Material::kSky;
};

// Maps a pixel (x, y, 1) to the world's direction of its ray, which reaches depth 1.
Eigen::Matrix3f RayFromPixel(const SceneView& view) {
  const Camera& camera = view.camera;
  Eigen::Matrix3d rays;
  rays << 1 / camera.fx_px, 0, -camera.cx_px / camera.fx_px, 0, 1 / camera.fy_px,
      -camera.cy_px / camera.fy_px, 0, 0, 1;
  return (view.world_from_camera.rotation.toRotationMatrix() * rays).cast<float>();
}

float LightOn(const PatchSurface& surface, const Vector3f& normal, const Vector3f& towards_face,
              const Light& light) {
  // A face has two sides: the side that the eye sees is lit when the sun is on it too.
  const float facing = normal.dot(towards_face) > 0 ? -1.0F : 1.0F;
  float sun = facing * normal.dot(light.towards_sun);
  if (surface.material == Material::kLeaves) sun = 0.6F + 0.4F * sun;
  return surface.tone * (light.ambient + (1 - light.ambient) * std::max(sun, 0.0F));
}

SeenSurface Describe(const SceneFaces& scene, const SceneView& view, const DrawnFace& face,
                     const Eigen::Matrix3f& ray_from_pixel, const Vector3f& towards_face) {
  const FacePlacement& placement = scene.PlacementAt(view, face.placement);
  const PatchSurface& surface = scene.SurfaceOf(view, face);
  const Eigen::Matrix3f rotation =
      placement.world_from_mesh.rotation.toRotationMatrix().cast<float>();
  const auto inverse_scale = static_cast<float>(1 / placement.world_from_mesh.scale);
  const Vector3f eye =
      (view.world_from_camera.translation - placement.world_from_mesh.translation).cast<float>();
  const Vector3f u_axis = inverse_scale * (rotation * surface.u_axis);
  const Vector3f v_axis = inverse_scale * (rotation * surface.v_axis);
  return {.u_slope = ray_from_pixel.transpose() * u_axis,
          .v_slope = ray_from_pixel.transpose() * v_axis,
          .nearness = face.nearness,
          .u_at_eye = u_axis.dot(eye) + surface.u_offset_m,
          .v_at_eye = v_axis.dot(eye) + surface.v_offset_m,
          .light = LightOn(surface, rotation * surface.normal, towards_face, scene.light()),
          .seed = surface.seed ^ placement.seed,
          .material = surface.material};
}

// Holds places of one material that wait for being shaded together.
struct Batch {
  size_t count = 0;
  std::array<const SeenSurface*, kLanes> surface;
  std::array<float, kLanes> x;
  std::array<float, kLanes> y;
  std::array<float, kLanes> share;   // Share of the pixel.
  std::array<float*, kLanes> pixel;  // Light is added to it.
};

// Distance takes contrast away: light of the air takes the place of the surface's.
float ThroughAir(float light, float depth_m) {
  constexpr float kRange_m = 900;
  constexpr float kAir = 0.75F;
  return light + (kAir - light) * (depth_m / (depth_m + kRange_m));
}

class BandPainter {
 public:
  BandPainter(const SceneFaces& scene, const SceneView& view,
              const std::vector<SeenSurface>& surfaces, const Eigen::Matrix3f& ray_from_pixel,
              cv::Mat* light)
      : scene_(scene),
        view_(view),
        surfaces_(surfaces),
        ray_from_pixel_(ray_from_pixel),
        light_(*light) {
    sky_.seed = scene.seed();
  }

  void Paint(int first_row, int last_row) {
    for (int y = first_row; y <= last_row; ++y) PaintRow(y);
    for (Batch& batch : batches_) Flush(batch);
  }

 private:
  const SeenSurface& SurfaceAt(int32_t face) const {
    return face == VisibilityBuffer::kNoFace ? sky_ : surfaces_[static_cast<size_t>(face)];
  }

  void PaintRow(int y) {
    const VisibilityBuffer& buffer = view_.buffer;
    const size_t samples = buffer.samples().size();
    std::vector<const int32_t*> faces(samples);
    for (size_t s = 0; s < samples; ++s) faces[s] = buffer.Faces(s, y);
    float* light = light_.ptr<float>(y);
    for (int x = 0; x < light_.cols; ++x) {
      const bool one_face = std::all_of(faces.begin() + 1, faces.end(),
                                        [&](const int32_t* row) { return row[x] == faces[0][x]; });
      if (one_face) {
        Add(SurfaceAt(faces[0][x]), static_cast<float>(x), static_cast<float>(y), 1, &light[x]);
      } else {
        PaintMixedPixel(faces, x, y, &light[x]);
      }
    }
  }

  // Each face that is seen in the pixel is shaded in the middle of its samples.
  void PaintMixedPixel(const std::vector<const int32_t*>& faces, int x, int y, float* light) {
    const std::vector<SampleOffset>& samples = view_.buffer.samples();
    const auto count = static_cast<float>(samples.size());
    for (size_t s = 0; s < samples.size(); ++s) {
      const int32_t face = faces[s][x];
      const auto shows = [&](size_t other) { return faces[other][x] == face; };
      bool first = true;
      for (size_t other = 0; other < s; ++other) first = first && !shows(other);
      if (!first) continue;
      float right = 0, down = 0, same = 0;
      for (size_t other = s; other < samples.size(); ++other) {
        if (!shows(other)) continue;
        right += samples[other].right_px;
        down += samples[other].down_px;
        ++same;
      }
      Add(SurfaceAt(face), static_cast<float>(x) + right / same,
          static_cast<float>(y) + down / same, same / count, light);
    }
  }

  void Add(const SeenSurface& surface, float x, float y, float share, float* pixel) {
    Batch& batch = batches_[static_cast<size_t>(surface.material)];
    const size_t i = batch.count++;
    batch.surface[i] = &surface;
    batch.x[i] = x;
    batch.y[i] = y;
    batch.share[i] = share;
    batch.pixel[i] = pixel;
    if (batch.count == kLanes) Flush(batch);
  }

  void Flush(Batch& batch) {
    if (batch.count == 0) return;
    // Lanes without a place repeat the first one's.
    for (size_t i = batch.count; i < kLanes; ++i) {
      batch.surface[i] = batch.surface[0];
      batch.x[i] = batch.x[0];
      batch.y[i] = batch.y[0];
    }
    if (batch.surface[0] == &sky_) {
      ShadeSky(batch);
    } else {
      ShadeSurface(batch);
    }
    batch.count = 0;
  }

  void ShadeSurface(const Batch& batch) const {
    SurfacePacket packet;
    packet.hit.fill(true);
    std::array<float, kLanes> depth_m;
    for (size_t i = 0; i < kLanes; ++i) {
      const SeenSurface& surface = *batch.surface[i];
      const float x = batch.x[i];
      const float y = batch.y[i];
      const auto at = [x, y](const Vector3f& f) { return f.x() * x + f.y() * y + f.z(); };
      const float depth = 1 / at(surface.nearness);
      const float u = at(surface.u_slope) * depth;
      const float v = at(surface.v_slope) * depth;
      const auto extent = [&](const Vector3f& slope, float value) {
        return depth * (std::abs(slope.x() - value * surface.nearness.x()) +
                        std::abs(slope.y() - value * surface.nearness.y()));
      };
      packet.u_m[i] = u + surface.u_at_eye;
      packet.v_m[i] = v + surface.v_at_eye;
      packet.pixel_u_m[i] = extent(surface.u_slope, u);
      packet.pixel_v_m[i] = extent(surface.v_slope, v);
      packet.seed[i] = surface.seed;
      packet.material[i] = surface.material;
      depth_m[i] = depth;
    }
    std::array<float, kLanes> reflectance;
    ComputeReflectance(packet, reflectance);
    const bool air = scene_.light().sky;
    for (size_t i = 0; i < batch.count; ++i) {
      const float lit = batch.surface[i]->light * reflectance[i];
      *batch.pixel[i] += batch.share[i] * (air ? ThroughAir(lit, depth_m[i]) : lit);
    }
  }

  // Shades places in a layer of clouds above the eye; without a sky it is dark.
  void ShadeSky(const Batch& batch) const {
    if (!scene_.light().sky) return;
    constexpr float kCloudHeight_m = 500;
    const float pixel = ray_from_pixel_.col(0).norm();
    SurfacePacket packet;
    packet.hit.fill(true);
    packet.material.fill(Material::kSky);
    packet.seed.fill(sky_.seed);
    for (size_t i = 0; i < kLanes; ++i) {
      const Vector3f ray = (ray_from_pixel_ * Vector3f(batch.x[i], batch.y[i], 1)).normalized();
      const float rise = std::max(-ray.y(), 0.0F) + 0.12F;
      packet.u_m[i] = kCloudHeight_m * ray.x() / rise;
      packet.v_m[i] = kCloudHeight_m * ray.z() / rise;
      packet.pixel_u_m[i] = kCloudHeight_m * pixel / rise;
      packet.pixel_v_m[i] = kCloudHeight_m * pixel / (rise * rise);
    }
    std::array<float, kLanes> reflectance;
    ComputeReflectance(packet, reflectance);
    for (size_t i = 0; i < batch.count; ++i) *batch.pixel[i] += batch.share[i] * reflectance[i];
  }

  const SceneFaces& scene_;
  const SceneView& view_;
  const std::vector<SeenSurface>& surfaces_;
  const Eigen::Matrix3f& ray_from_pixel_;
  cv::Mat& light_;
  SeenSurface sky_;
  std::array<Batch, kMaterials> batches_;
};

// Returns as a pixel where a sample sees each drawn face; faces that something nearer hid again
// have none.
std::vector<int32_t> FindSeen(const SceneView& view) {
  const VisibilityBuffer& buffer = view.buffer;
  std::vector<int32_t> pixel_of(view.drawn.size(), -1);
  for (size_t sample = 0; sample < buffer.samples().size(); ++sample) {
    for (int y = 0; y < buffer.height_px(); ++y) {
      const int32_t* faces = buffer.Faces(sample, y);
      int32_t before = VisibilityBuffer::kNoFace;
      for (int x = 0; x < buffer.width_px(); ++x) {
        if (faces[x] == before) continue;
        before = faces[x];
        if (before != VisibilityBuffer::kNoFace) {
          pixel_of[static_cast<size_t>(before)] = y * buffer.width_px() + x;
        }
      }
    }
  }
  return pixel_of;
}

std::vector<SeenSurface> DescribeSeen(const SceneFaces& scene, const SceneView& view,
                                      const Eigen::Matrix3f& ray_from_pixel) {
  const std::vector<int32_t> pixel_of = FindSeen(view);
  std::vector<SeenSurface> surfaces(view.drawn.size());
  for (size_t i = 0; i < surfaces.size(); ++i) {
    if (pixel_of[i] < 0) continue;
    const int width = view.buffer.width_px();
    const Vector3f pixel(static_cast<float>(pixel_of[i] % width),
                         static_cast<float>(pixel_of[i] / width), 1);
    surfaces[i] = Describe(scene, view, view.drawn[i], ray_from_pixel, ray_from_pixel * pixel);
  }
  return surfaces;
}

}  // namespace

cv::Mat ComputeLight(const SceneFaces& scene, const SceneView& view, int threads) {
  constexpr int kBandRows = 8;
  const Eigen::Matrix3f ray_from_pixel = RayFromPixel(view);
  const std::vector<SeenSurface> surfaces = DescribeSeen(scene, view, ray_from_pixel);
  cv::Mat light = cv::Mat::zeros(view.camera.height_px, view.camera.width_px, CV_32FC1);
  const int bands = (light.rows + kBandRows - 1) / kBandRows;
  ParallelRows(threads, bands, [&](int band) {
    const int first = band * kBandRows;
    BandPainter(scene, view, surfaces, ray_from_pixel, &light)
        .Paint(first, std::min(first + kBandRows, light.rows) - 1);
  });
  return light;
}

}  // namespace corbslam
