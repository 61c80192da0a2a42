#include "services/simulation/renderer.h"

#include <array>
#include <functional>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "services/simulation/obstructions.h"
#include "services/simulation/parallel_rows.h"
#include "services/simulation/scene_faces.h"
#include "services/simulation/shading.h"
#include "slam/geometry/interpolation.h"
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
    if (shot.bands.empty()) {
      return Finish(shot, Expose(WholePicture(shot), [&](const Rigid3d& pose) {
                      return LightAt(camera, pose, shot.time_s, options_.threads);
                    }));
    }
    return Finish(
        shot, DrawBands(camera, shot, CV_32FC1, [&](const Camera& rows, const RowBand& band) {
          return Expose(band,
                        [&](const Rigid3d& pose) { return LightAt(rows, pose, band.time_s, 1); });
        }));
  }

  cv::Mat DrawGrey(const LensView& view, const Shot& shot) const override {
    return Finish(
        shot, Expose(WholePicture(shot), [&](const Rigid3d& pose) {
          std::vector<cv::Mat> sides;
          for (const LensView::Side& side : view.sides()) {
            const Rigid3d turned = {side.camera_from_side, Eigen::Vector3d::Zero()};
            sides.push_back(LightAt(side.pinhole, pose * turned, shot.time_s, options_.threads));
          }
          return view.Resample(sides, options_.threads);
        }));
  }

  cv::Mat DrawDepth(const Camera& camera, const Shot& shot) const override {
    if (shot.bands.empty()) return DepthAt(camera, shot.world_from_camera, shot.time_s);
    return DrawBands(camera, shot, CV_32FC1, [&](const Camera& rows, const RowBand& band) {
      return DepthAt(rows, band.world_from_camera, band.time_s);
    });
  }

 private:
  using LightFrom = std::function<cv::Mat(const Rigid3d&)>;
  using DrawRows = std::function<cv::Mat(const Camera&, const RowBand&)>;

  static RowBand WholePicture(const Shot& shot) {
    return {shot.world_from_camera, shot.world_from_camera_at_close, shot.time_s};
  }

  cv::Mat LightAt(const Camera& camera, const Rigid3d& world_from_camera, double time_s,
                  int threads) const {
    const SceneView view =
        scene_.See(camera, world_from_camera, time_s, {kSamples.begin(), kSamples.end()});
    return ComputeLight(scene_, view, threads);
  }

  cv::Mat DepthAt(const Camera& camera, const Rigid3d& world_from_camera, double time_s) const {
    const SceneView view = scene_.See(camera, world_from_camera, time_s, {SampleOffset()});
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

  // Draws each band with a camera that has its rows alone.
  cv::Mat DrawBands(const Camera& camera, const Shot& shot, int type, const DrawRows& draw) const {
    cv::Mat picture(camera.height_px, camera.width_px, type);
    const int bands = static_cast<int>(shot.bands.size());
    ParallelRows(options_.threads, bands, [&](int band) {
      const int first = band * camera.height_px / bands;
      const int end = (band + 1) * camera.height_px / bands;
      if (end == first) return;
      Camera rows = camera;
      rows.cy_px -= first;
      rows.height_px = end - first;
      draw(rows, shot.bands[static_cast<size_t>(band)]).copyTo(picture.rowRange(first, end));
    });
    return picture;
  }

  // Returns the mean over the time of the open shutter of the light that is seen from a pose.
  cv::Mat Expose(const RowBand& band, const LightFrom& light_from) const {
    const int instants =
        band.world_from_camera_at_close.has_value() ? options_.lens.motion_blur_samples : 1;
    cv::Mat light = light_from(band.world_from_camera);
    for (int i = 1; i < instants; ++i) {
      const Rigid3d pose = Interpolate(band.world_from_camera, *band.world_from_camera_at_close,
                                       static_cast<double>(i) / (instants - 1));
      cv::add(light, light_from(pose), light);
    }
    if (instants > 1) light.convertTo(light, CV_32FC1, 1.0 / instants);
    return light;
  }

  // Returns the picture that the lens and the imager make of the light.
  cv::Mat Finish(const Shot& shot, cv::Mat light) const {
    Defocus(shot.defocus_px, light);
    CoverByHand(shot.covered, light);
    Lens lens = options_.lens;
    lens.exposure *= shot.exposure;
    return Develop(light, lens, shot.time_s, shot.stream, options_.threads);
  }

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
