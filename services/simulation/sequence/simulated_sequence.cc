#include "services/simulation/sequence/simulated_sequence.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/simulation/inertial/imu_errors.h"
#include "services/simulation/inertial/measured_motion.h"
#include "services/simulation/motion/pose_sequence.h"
#include "services/simulation/renderer.h"
#include "services/simulation/sequence/camera_rig.h"
#include "services/simulation/sequence/depth_image.h"
#include "services/simulation/sequence/frame_clock.h"
#include "services/simulation/sequence/measured_flight.h"
#include "services/simulation/sequence/picture_events.h"
#include "services/simulation/sequence/simulated_world.h"
#include "services/simulation/sequence/truth_error.h"
#include "slam/camera/depth_registration.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

class DrawnSequence : public SimulatedSequence {
 public:
  // `measured` by a real IMU, from the way's beginning on; else it is empty.
  DrawnSequence(const SimulationSpec& spec, PoseSequence way, ImuSamples measured)
      : spec_(spec),
        way_(std::move(way)),
        measured_(std::move(measured)),
        rig_(MakeRig(spec)),
        clock_(spec, rig_.rate_hz, way_.duration_ns()) {}

  const SimulationSpec& spec() const override { return spec_; }
  const SensorCalibration& calibration() const override { return rig_.calibration; }
  double rate_hz() const override { return rig_.rate_hz; }
  size_t frame_count() const override { return clock_.frame_count(); }
  int64_t timestamp_ns(size_t frame) const override { return clock_.TimestampAt(frame); }
  Rigid3d world_from_camera(size_t frame) const override { return PoseAt(frame, 0); }
  const ImuSamples& imu() const override;
  absl::StatusOr<SensorImages> Render(size_t frame) const override;

 private:
  // Returns where the camera is so long after the sequence began; of a sequence without a kidnap.
  Rigid3d PoseOf(int64_t elapsed_ns) const;
  ImuSamples MeasureImu(const ImuCalibration& imu) const;
  Rigid3d PoseAt(size_t frame, int64_t since_ns) const;
  // Returns the renderer's shot of a camera that sits somewhere beside the left one; its pictures
  // have noise of their own by `camera`, 0 or 1.
  Shot ShotOf(size_t frame, int camera, const Rigid3d& left_from_camera) const;
  RowBand BandOf(size_t frame, double since_s, const Rigid3d& left_from_camera) const;
  // What draws: the world, and the lenses of both cameras where the spec says which.
  struct Studio {
    std::unique_ptr<Renderer> renderer;
    std::vector<LensView> lenses;
    std::optional<DepthRegistration> registration;  // Where depth is measured from aside.
  };
  absl::StatusOr<Studio> MakeStudio() const;
  Rigid3d ColourFromDepth() const {
    return {Eigen::Quaterniond::Identity(), {spec_.depth_aside_m, 0, 0}};
  }
  absl::StatusOr<const Studio*> GetStudio() const;
  absl::StatusOr<SensorImages> Draw(const Studio& studio, size_t frame) const;
  cv::Mat DrawGrey(const Studio& studio, size_t frame, int camera) const;
  // Draws the right picture, or the depths.
  absl::StatusOr<cv::Mat> DrawOther(const Studio& studio, size_t frame) const;
  SensorImages Dark(size_t frame) const;

  const SimulationSpec spec_;
  const PoseSequence way_;
  const ImuSamples measured_;
  const SimulatedRig rig_;
  const FrameClock clock_;
  // The first call sets it, under once_.
  mutable std::once_flag once_;
  mutable absl::StatusOr<Studio> studio_;
  // The first call sets it, under imu_once_.
  mutable std::once_flag imu_once_;
  mutable ImuSamples imu_;
};

Rigid3d DrawnSequence::PoseAt(size_t frame, int64_t since_ns) const {
  const Rigid3d pose = way_.PoseAt(clock_.WayTimeAt(frame, since_ns));
  return spec_.turned ? TurnedBack(pose) : pose;
}

Rigid3d DrawnSequence::PoseOf(int64_t elapsed_ns) const {
  const Rigid3d pose = way_.PoseAt(clock_.WayTimeOf(elapsed_ns));
  return spec_.turned ? TurnedBack(pose) : pose;
}

ImuSamples DrawnSequence::MeasureImu(const ImuCalibration& imu) const {
  const Rigid3d camera_from_imu = imu.imu_from_camera.Inverse();
  const auto motion = [&](int64_t elapsed_ns) { return PoseOf(elapsed_ns) * camera_from_imu; };
  ImuSamples ideal = spec_.imu.measured != nullptr
                         ? measured_
                         : MeasureMotion(motion, clock_.PhysicalSpan(), spec_.imu.rate_hz);
  ImuSamples samples = WithErrors(spec_.imu, spec_.lens.noise_seed, std::move(ideal));
  for (ImuSample& sample : samples) sample.timestamp_ns += std::llround(1e9 * spec_.start_s);
  return samples;
}

const ImuSamples& DrawnSequence::imu() const {
  const std::optional<ImuCalibration>& told = std::visit(
      [](const auto& sensor) -> const std::optional<ImuCalibration>& { return sensor.imu; },
      rig_.calibration);
  if (!told.has_value()) return imu_;
  std::call_once(imu_once_, [&] { imu_ = MeasureImu(*told); });
  return imu_;
}

RowBand DrawnSequence::BandOf(size_t frame, double since_s, const Rigid3d& left_from_camera) const {
  return {PoseAt(frame, std::llround(since_s * 1e9)) * left_from_camera,
          1e-9 * static_cast<double>(clock_.ElapsedAt(frame)) + since_s};
}

Shot DrawnSequence::ShotOf(size_t frame, int camera, const Rigid3d& left_from_camera) const {
  // Rows that are exposed together: what lies ten metres aside of a fast car moves by a fifth of a
  // pixel meanwhile.
  constexpr int kRowsOfBand = 4;
  const RowBand middle = BandOf(frame, 0, left_from_camera);
  Shot shot;
  shot.world_from_camera = middle.world_from_camera;
  shot.time_s = middle.time_s;
  if (spec_.rolling_shutter_ms > 0) {
    const int bands = (rig_.camera.height_px + kRowsOfBand - 1) / kRowsOfBand;
    for (int i = 0; i < bands; ++i) {
      const double share = (i + 0.5) / bands - 0.5;
      shot.bands.push_back(
          BandOf(frame, 1e-3 * spec_.rolling_shutter_ms * share, left_from_camera));
    }
  }
  shot.stream = 2 * frame + static_cast<uint64_t>(camera);
  const PictureEvents events = EventsAt(spec_, shot.time_s);
  shot.exposure = events.exposure;
  shot.defocus_px = events.defocus_px;
  shot.covered = events.covered;
  return shot;
}

absl::StatusOr<DrawnSequence::Studio> DrawnSequence::MakeStudio() const {
  Studio studio;
  // A frame's two pictures are drawn at the same time.
  studio.renderer = std::make_unique<Renderer>(BuildWorld(spec_, way_), spec_.lens,
                                               std::max(1, spec_.threads / 2));
  if (spec_.depth_aside_m != 0) {
    const Camera& camera = rig_.camera;
    const RawCamera raw = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, {}};
    const cv::Size size(camera.width_px, camera.height_px);
    ASSIGN_OR_RETURN(studio.registration,
                     DepthRegistration::Make({raw, size, raw, size, ColourFromDepth()}));
  }
  if (!spec_.pair.has_value()) return studio;
  for (const RawCamera& camera : {spec_.pair->left, spec_.pair->right}) {
    ASSIGN_OR_RETURN(LensView lens,
                     LensView::Make(camera, rig_.camera.width_px, rig_.camera.height_px));
    studio.lenses.push_back(std::move(lens));
  }
  return studio;
}

absl::StatusOr<const DrawnSequence::Studio*> DrawnSequence::GetStudio() const {
  std::call_once(once_, [this] { studio_ = MakeStudio(); });
  RETURN_IF_ERROR(studio_.status());
  return &*studio_;
}

absl::StatusOr<SensorImages> DrawnSequence::Draw(const Studio& studio, size_t frame) const {
  SensorImages images;
  images.timestamp_ns = timestamp_ns(frame);
  cv::Mat& other = rig_.left_from_right.has_value() ? images.right : images.depth;
  const auto policy = spec_.threads > 1 ? std::launch::async : std::launch::deferred;
  std::future<absl::StatusOr<cv::Mat>> drawing =
      std::async(policy, [&] { return DrawOther(studio, frame); });
  images.grey = DrawGrey(studio, frame, 0);
  ASSIGN_OR_RETURN(other, drawing.get());
  return images;
}

cv::Mat DrawnSequence::DrawGrey(const Studio& studio, size_t frame, int camera) const {
  const Shot shot =
      ShotOf(frame, camera, camera == 1 ? *rig_.left_from_right : Rigid3d::Identity());
  if (studio.lenses.empty()) return studio.renderer->DrawGrey(rig_.camera, shot);
  return studio.renderer->DrawGrey(studio.lenses[static_cast<size_t>(camera)], shot);
}

absl::StatusOr<cv::Mat> DrawnSequence::DrawOther(const Studio& studio, size_t frame) const {
  if (rig_.left_from_right.has_value()) return DrawGrey(studio, frame, 1);
  DepthImageOptions depth;
  depth.units_per_m = std::get<RgbdCalibration>(rig_.calibration).depth_units_per_m;
  depth.noise_m = spec_.depth_noise_m;
  depth.noise_seed = spec_.lens.noise_seed;
  const Shot shot = ShotOf(frame, 0, ColourFromDepth());
  const cv::Mat image = MakeDepthImage(studio.renderer->DrawDepth(rig_.camera, shot), depth, frame);
  if (!studio.registration.has_value()) return image;
  return studio.registration->Register(image, depth.units_per_m);
}

SensorImages DrawnSequence::Dark(size_t frame) const {
  const cv::Size size(rig_.camera.width_px, rig_.camera.height_px);
  SensorImages images;
  images.timestamp_ns = timestamp_ns(frame);
  images.grey = cv::Mat::zeros(size, CV_8UC1);
  cv::Mat& other = rig_.left_from_right.has_value() ? images.right : images.depth;
  other = cv::Mat::zeros(size, rig_.left_from_right.has_value() ? CV_8UC1 : CV_16UC1);
  return images;
}

absl::StatusOr<SensorImages> DrawnSequence::Render(size_t frame) const {
  if (frame >= frame_count()) {
    return absl::OutOfRangeError(
        absl::StrCat("frame ", frame, ": the sequence has ", frame_count()));
  }
  try {
    if (clock_.IsDark(frame)) return Dark(frame);
    ASSIGN_OR_RETURN(const Studio* studio, GetStudio());
    return Draw(*studio, frame);
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat("frame ", frame, ": ", exception.what()));
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<SimulatedSequence>> SimulatedSequence::Make(
    const SimulationSpec& spec) {
  RETURN_IF_ERROR(Validate(spec));
  ImuSamples measured;
  std::optional<PoseSequence> way;
  if (spec.imu.measured != nullptr) {
    ASSIGN_OR_RETURN(MeasuredFlight flight, ReadMeasuredFlight(spec));
    way = std::move(flight.way);
    measured = std::move(flight.samples);
  } else {
    ASSIGN_OR_RETURN(way, MakeWay(spec));
  }
  auto sequence = std::make_unique<DrawnSequence>(spec, *std::move(way), std::move(measured));
  if (sequence->frame_count() == 0) {
    return absl::InvalidArgumentError("the simulated way ends before its first frame");
  }
  return sequence;
}

Trajectory TrueTrajectory(const SimulatedSequence& sequence) {
  const SimulationSpec& spec = sequence.spec();
  const TruthError error{spec.truth_error_m, spec.truth_error_deg, spec.seed};
  Trajectory trajectory;
  trajectory.reserve(sequence.frame_count());
  for (size_t i = 0; i < sequence.frame_count(); ++i) {
    const int64_t time_ns = sequence.timestamp_ns(i);
    const double time_s = 1e-9 * static_cast<double>(time_ns);
    trajectory.push_back({time_ns, MeasuredPose(sequence.world_from_camera(i), time_s, error)});
  }
  return trajectory;
}

}  // namespace corbslam
