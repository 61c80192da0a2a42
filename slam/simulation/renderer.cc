#include "slam/simulation/renderer.h"

#include <array>
#include <opencv2/core.hpp>
#include <utility>

#include "slam/geometry/interpolation.h"
#include "slam/simulation/scene_faces.h"
#include "slam/simulation/shading.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// Where surfaces meet, a pixel is the mean of these.
constexpr std::array<SampleOffset, 3> kSamples = {{{0, 0}, {-0.33F, 0.25F}, {0.33F, -0.25F}}};

class RasterisingRenderer final : public Renderer {
 public:
  RasterisingRenderer(SceneFaces scene, const RenderOptions& options)
      : scene_(std::move(scene)), options_(options) {}

  cv::Mat DrawGrey(const Camera& camera, const Shot& shot) const override {
    const int instants =
        shot.world_from_camera_at_close.has_value() ? options_.lens.motion_blur_samples : 1;
    cv::Mat light;
    for (int i = 0; i < instants; ++i) {
      const Rigid3d pose =
          instants == 1 ? shot.world_from_camera
                        : Interpolate(shot.world_from_camera, *shot.world_from_camera_at_close,
                                      static_cast<double>(i) / (instants - 1));
      const SceneView view =
          scene_.See(camera, pose, shot.time_s, {kSamples.begin(), kSamples.end()});
      const cv::Mat at_instant = ComputeLight(scene_, view, options_.threads);
      if (i == 0) {
        light = at_instant;
      } else {
        cv::add(light, at_instant, light);
      }
    }
    if (instants > 1) light.convertTo(light, CV_32FC1, 1.0 / instants);
    return Develop(light, options_.lens, shot.time_s, shot.stream, options_.threads);
  }

  cv::Mat DrawDepth(const Camera& camera, const Shot& shot) const override {
    const SceneView view =
        scene_.See(camera, shot.world_from_camera, shot.time_s, {SampleOffset()});
    cv::Mat depth(camera.height_px, camera.width_px, CV_32FC1);
    for (int y = 0; y < depth.rows; ++y) {
      const int32_t* faces = view.buffer.Faces(0, y);
      const float* nearness = view.buffer.Nearness(0, y);
      float* to = depth.ptr<float>(y);
      for (int x = 0; x < depth.cols; ++x) {
        to[x] = faces[x] == VisibilityBuffer::kNoFace ? 0 : 1 / nearness[x];
      }
    }
    return depth;
  }

 private:
  const SceneFaces scene_;
  const RenderOptions options_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Make(const Scene& scene,
                                                         const RenderOptions& options) {
  RETURN_IF_ERROR(Validate(options.lens));
  ASSIGN_OR_RETURN(SceneFaces faces, SceneFaces::Make(scene));
  return std::make_unique<RasterisingRenderer>(std::move(faces), options);
}

}  // namespace corbslam
