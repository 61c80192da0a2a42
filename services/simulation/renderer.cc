#include "services/simulation/renderer.h"

#include <array>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "services/simulation/obstructions.h"
#include "services/simulation/parallel_rows.h"
#include "services/simulation/shading.h"

namespace corbslam {
namespace {

// Where surfaces meet, a pixel is the mean of these.
constexpr std::array<SampleOffset, 3> kSamples = {{{0, 0}, {-0.33F, 0.25F}, {0.33F, -0.25F}}};

RowBand WholePicture(const Shot& shot) { return {shot.world_from_camera, shot.time_s}; }

}  // namespace

cv::Mat Renderer::DrawGrey(const Camera& camera, const Shot& shot) const {
  if (shot.bands.empty()) return Finish(shot, LightAt(camera, WholePicture(shot), threads_));
  return Finish(shot, DrawBands(camera, shot, [&](const Camera& rows, const RowBand& band) {
                  return LightAt(rows, band, 1);
                }));
}

cv::Mat Renderer::DrawGrey(const LensView& view, const Shot& shot) const {
  std::vector<cv::Mat> sides;
  for (const LensView::Side& side : view.sides()) {
    RowBand turned = WholePicture(shot);
    turned.world_from_camera =
        turned.world_from_camera * Rigid3d{side.camera_from_side, Eigen::Vector3d::Zero()};
    sides.push_back(LightAt(side.pinhole, turned, threads_));
  }
  return Finish(shot, view.Resample(sides, threads_));
}

cv::Mat Renderer::DrawDepth(const Camera& camera, const Shot& shot) const {
  if (shot.bands.empty()) return DepthAt(camera, WholePicture(shot));
  return DrawBands(camera, shot,
                   [&](const Camera& rows, const RowBand& band) { return DepthAt(rows, band); });
}

cv::Mat Renderer::LightAt(const Camera& camera, const RowBand& when, int threads) const {
  const SceneView view =
      scene_.See(camera, when.world_from_camera, when.time_s, {kSamples.begin(), kSamples.end()});
  return ComputeLight(scene_, view, threads);
}

cv::Mat Renderer::DepthAt(const Camera& camera, const RowBand& when) const {
  const SceneView view = scene_.See(camera, when.world_from_camera, when.time_s, {SampleOffset()});
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

cv::Mat Renderer::DrawBands(const Camera& camera, const Shot& shot, const DrawRows& draw) const {
  cv::Mat picture(camera.height_px, camera.width_px, CV_32FC1);
  const int bands = static_cast<int>(shot.bands.size());
  ParallelRows(threads_, bands, [&](int band) {
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

cv::Mat Renderer::Finish(const Shot& shot, cv::Mat light) const {
  Defocus(shot.defocus_px, light);
  CoverByHand(shot.covered, light);
  Lens lens = lens_;
  lens.exposure *= shot.exposure;
  return Develop(light, lens, shot.time_s, shot.stream, threads_);
}

}  // namespace corbslam
