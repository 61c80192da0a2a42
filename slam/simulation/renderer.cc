#include "slam/simulation/renderer.h"

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <utility>

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

// The rays of the centres of eight pixels of a row, from column `x` on.
RayPacket RowPacket(const View& view, int x, int y, int width) {
  RayPacket rays = StartPacket(view);
  for (int lane = 0; lane < kLanes && x + lane < width; ++lane) {
    SetRay(view, static_cast<float>(x + lane), static_cast<float>(y), static_cast<size_t>(lane),
           rays);
  }
  return rays;
}

// Light of pixels by one ray each, then of those where surfaces meet by four more.
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
    ParallelRows(threads_, light_.rows, [this](int y) { PaintRow(y); });
    cv::Mat smooth = light_.clone();
    ParallelRows(threads_, light_.rows, [&](int y) { RefineRow(y, smooth); });
    return smooth;
  }

 private:
  void PaintRow(int y) {
    for (int x = 0; x < light_.cols; x += kLanes) {
      const LightPacket packet =
          ComputeLight(caster_, movers_, RowPacket(view_, x, y, light_.cols));
      for (int lane = 0; lane < kLanes && x + lane < light_.cols; ++lane) {
        light_.at<float>(y, x + lane) = packet.light[static_cast<size_t>(lane)];
        patches_.at<int32_t>(y, x + lane) =
            static_cast<int32_t>(packet.patch[static_cast<size_t>(lane)]);
      }
    }
  }

  bool IsEdge(int x, int y) const {
    const int32_t here = patches_.at<int32_t>(y, x);
    return (x > 0 && patches_.at<int32_t>(y, x - 1) != here) ||
           (x + 1 < patches_.cols && patches_.at<int32_t>(y, x + 1) != here) ||
           (y > 0 && patches_.at<int32_t>(y - 1, x) != here) ||
           (y + 1 < patches_.rows && patches_.at<int32_t>(y + 1, x) != here);
  }

  // Two pixels a packet, four places of a rotated grid each.
  void RefineRow(int y, cv::Mat& smooth) const {
    std::array<int, 2> columns;
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

  void RefinePixels(const std::array<int, 2>& columns, size_t count, int y, cv::Mat& smooth) const {
    constexpr size_t kPlaces = 4;
    constexpr std::array<float, kPlaces> kRight = {-0.125F, 0.375F, -0.375F, 0.125F};
    constexpr std::array<float, kPlaces> kDown = {-0.375F, -0.125F, 0.125F, 0.375F};
    RayPacket rays = StartPacket(view_);
    for (size_t i = 0; i < count; ++i) {
      for (size_t k = 0; k < kPlaces; ++k) {
        SetRay(view_, static_cast<float>(columns[i]) + kRight[k], static_cast<float>(y) + kDown[k],
               kPlaces * i + k, rays);
      }
    }
    const LightPacket packet = ComputeLight(caster_, movers_, rays);
    for (size_t i = 0; i < count; ++i) {
      float sum = 0;
      for (size_t k = 0; k < kPlaces; ++k) sum += packet.light[kPlaces * i + k];
      smooth.at<float>(y, columns[i]) = sum / kPlaces;
    }
  }

  const RayCaster& caster_;
  const MoverPoses* const movers_;
  const View view_;
  const int threads_;
  cv::Mat light_;
  cv::Mat patches_;
};

Rigid3d Between(const Rigid3d& a, const Rigid3d& b, double share) {
  return {a.rotation.slerp(share, b.rotation), (1 - share) * a.translation + share * b.translation};
}

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
      const Rigid3d pose = samples == 1
                               ? shot.world_from_camera
                               : Between(shot.world_from_camera, *shot.world_from_camera_at_close,
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
    ParallelRows(options_.threads, depth.rows, [&](int y) {
      HitPacket hits;
      for (int x = 0; x < depth.cols; x += kLanes) {
        caster_->Cast(RowPacket(view, x, y, depth.cols), movers.get(), hits);
        for (int lane = 0; lane < kLanes && x + lane < depth.cols; ++lane) {
          depth.at<float>(y, x + lane) = hits.depth_m[static_cast<size_t>(lane)];
        }
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
