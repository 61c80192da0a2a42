#include "slam/simulation/renderer.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <utility>

#include "slam/geometry/interpolation.h"
#include "slam/simulation/parallel_rows.h"
#include "slam/simulation/ray_caster.h"
#include "slam/simulation/shading.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// Rays of a pinhole camera: the one of pixel (x, y) is corner + x right + y down.
struct View {
  Eigen::Vector3f origin;
  Eigen::Vector3f corner;
  Eigen::Vector3f right;
  Eigen::Vector3f down;
};

View MakeView(const Camera& camera, const Rigid3d& world_from_camera) {
  const Eigen::Matrix3d axes = world_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3d right = axes.col(0) / camera.fx_px;
  const Eigen::Vector3d down = axes.col(1) / camera.fy_px;
  const Eigen::Vector3d corner = axes.col(2) - camera.cx_px * right - camera.cy_px * down;
  return {.origin = world_from_camera.translation.cast<float>(),
          .corner = corner.cast<float>(),
          .right = right.cast<float>(),
          .down = down.cast<float>()};
}

RayPacket StartPacket(const View& view) {
  RayPacket rays;
  rays.origin = view.origin;
  rays.pixel_right = view.right;
  rays.pixel_down = view.down;
  rays.active.fill(false);
  rays.direction_x.fill(0);
  rays.direction_y.fill(0);
  rays.direction_z.fill(1);
  return rays;
}

void SetRay(const View& view, float x, float y, size_t lane, RayPacket& rays) {
  const Eigen::Vector3f direction = view.corner + x * view.right + y * view.down;
  rays.direction_x[lane] = direction.x();
  rays.direction_y[lane] = direction.y();
  rays.direction_z[lane] = direction.z();
  rays.active[lane] = true;
}

// Pixels of a packet: a small square, so that their rays stay together.
constexpr int kBlockColumns = 4;
constexpr int kBlockRows = 4;
static_assert(kBlockColumns * kBlockRows == kLanes);

// Where surfaces meet, a pixel is the mean of its centre's ray and this many more.
constexpr size_t kPlaces = 2;
constexpr size_t kRefinedAtOnce = kLanes / kPlaces;

// Calls `visit(lane, x, y)` for the pixels of the block at (x, y) that are in the picture.
template <typename Visit>
void ForBlock(const cv::Mat& picture, int x, int y, Visit visit) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const int column = x + lane % kBlockColumns;
    const int row = y + lane / kBlockColumns;
    if (column < picture.cols && row < picture.rows) visit(static_cast<size_t>(lane), column, row);
  }
}

// The rays of the centres of the block's pixels.
RayPacket BlockPacket(const View& view, const cv::Mat& picture, int x, int y) {
  RayPacket rays = StartPacket(view);
  ForBlock(picture, x, y, [&](size_t lane, int column, int row) {
    SetRay(view, static_cast<float>(column), static_cast<float>(row), lane, rays);
  });
  return rays;
}

int BlocksDown(const cv::Mat& picture) { return (picture.rows + kBlockRows - 1) / kBlockRows; }

// Light of pixels by one ray each, then of those where surfaces meet by more.
class LightPainter {
 public:
  LightPainter(const RayCaster& caster, const MoverPoses* movers, const Camera& camera,
               const View& view, int threads)
      : caster_(caster),
        movers_(movers),
        view_(view),
        threads_(threads),
        light_(camera.height_px, camera.width_px, CV_32FC1),
        patches_(camera.height_px, camera.width_px, CV_32SC1) {}

  cv::Mat Paint() {
    ParallelRows(threads_, BlocksDown(light_), [this](int i) { PaintBlocks(i * kBlockRows); });
    cv::Mat smooth = light_.clone();
    ParallelRows(threads_, light_.rows, [&](int y) { RefineRow(y, smooth); });
    return smooth;
  }

 private:
  void PaintBlocks(int y) {
    for (int x = 0; x < light_.cols; x += kBlockColumns) {
      const LightPacket packet = ComputeLight(caster_, movers_, BlockPacket(view_, light_, x, y));
      ForBlock(light_, x, y, [&](size_t lane, int column, int row) {
        light_.at<float>(row, column) = packet.light[lane];
        patches_.at<int32_t>(row, column) = static_cast<int32_t>(packet.patch[lane]);
      });
    }
  }

  // Whether another surface of another brightness lies within a pixel.
  bool Differs(int x, int y, int32_t patch, float light) const {
    constexpr float kVisible = 0.04F;
    return x >= 0 && y >= 0 && x < light_.cols && y < light_.rows &&
           patches_.at<int32_t>(y, x) != patch &&
           std::abs(light_.at<float>(y, x) - light) > kVisible;
  }
  bool IsEdge(int x, int y) const {
    const int32_t patch = patches_.at<int32_t>(y, x);
    const float light = light_.at<float>(y, x);
    return Differs(x - 1, y, patch, light) || Differs(x + 1, y, patch, light) ||
           Differs(x, y - 1, patch, light) || Differs(x, y + 1, patch, light);
  }

  // Several pixels a packet.
  void RefineRow(int y, cv::Mat& smooth) const {
    std::array<int, kRefinedAtOnce> columns;
    size_t waiting = 0;
    for (int x = 0; x < light_.cols; ++x) {
      if (!IsEdge(x, y)) continue;
      columns[waiting++] = x;
      if (waiting < columns.size()) continue;
      RefinePixels(columns, waiting, y, smooth);
      waiting = 0;
    }
    if (waiting > 0) RefinePixels(columns, waiting, y, smooth);
  }

  void RefinePixels(const std::array<int, kRefinedAtOnce>& columns, size_t count, int y,
                    cv::Mat& smooth) const {
    constexpr std::array<float, kPlaces> kRight = {-0.33F, 0.33F};
    constexpr std::array<float, kPlaces> kDown = {0.25F, -0.25F};
    RayPacket rays = StartPacket(view_);
    for (size_t i = 0; i < count; ++i) {
      for (size_t k = 0; k < kPlaces; ++k) {
        SetRay(view_, static_cast<float>(columns[i]) + kRight[k], static_cast<float>(y) + kDown[k],
               kPlaces * i + k, rays);
      }
    }
    const LightPacket packet = ComputeLight(caster_, movers_, rays);
    for (size_t i = 0; i < count; ++i) {
      float sum = light_.at<float>(y, columns[i]);
      for (size_t k = 0; k < kPlaces; ++k) sum += packet.light[kPlaces * i + k];
      smooth.at<float>(y, columns[i]) = sum / (kPlaces + 1);
    }
  }

  const RayCaster& caster_;
  const MoverPoses* const movers_;
  const View view_;
  const int threads_;
  cv::Mat light_;
  cv::Mat patches_;
};

class RayCastingRenderer final : public Renderer {
 public:
  RayCastingRenderer(std::unique_ptr<RayCaster> caster, const RenderOptions& options)
      : caster_(std::move(caster)), options_(options) {}

  cv::Mat DrawGrey(const Camera& camera, const Shot& shot) const override {
    const auto movers = caster_->PlaceMovers(shot.time_s);
    const int samples =
        shot.world_from_camera_at_close.has_value() ? options_.lens.motion_blur_samples : 1;
    cv::Mat light;
    for (int i = 0; i < samples; ++i) {
      const Rigid3d pose =
          samples == 1 ? shot.world_from_camera
                       : Interpolate(shot.world_from_camera, *shot.world_from_camera_at_close,
                                     static_cast<double>(i) / (samples - 1));
      LightPainter painter(*caster_, movers.get(), camera, MakeView(camera, pose),
                           options_.threads);
      if (i == 0) {
        light = painter.Paint();
      } else {
        cv::add(light, painter.Paint(), light);
      }
    }
    if (samples > 1) light.convertTo(light, CV_32FC1, 1.0 / samples);
    return Develop(light, options_.lens, shot.time_s, shot.stream, options_.threads);
  }

  cv::Mat DrawDepth(const Camera& camera, const Shot& shot) const override {
    const auto movers = caster_->PlaceMovers(shot.time_s);
    const View view = MakeView(camera, shot.world_from_camera);
    cv::Mat depth(camera.height_px, camera.width_px, CV_32FC1);
    ParallelRows(options_.threads, BlocksDown(depth), [&](int i) {
      HitPacket hits;
      const int y = i * kBlockRows;
      for (int x = 0; x < depth.cols; x += kBlockColumns) {
        caster_->Cast(BlockPacket(view, depth, x, y), movers.get(), hits);
        ForBlock(depth, x, y, [&](size_t lane, int column, int row) {
          depth.at<float>(row, column) = hits.depth_m[lane];
        });
      }
    });
    return depth;
  }

 private:
  const std::unique_ptr<RayCaster> caster_;
  const RenderOptions options_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Make(Scene scene,
                                                         const RenderOptions& options) {
  RETURN_IF_ERROR(Validate(options.lens));
  ASSIGN_OR_RETURN(auto caster, RayCaster::Make(std::move(scene)));
  return std::make_unique<RayCastingRenderer>(std::move(caster), options);
}

}  // namespace corbslam
