#include "services/simulated_source/simulated_reader.h"

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/lists/imu_list.h"
#include "services/simulation/sequence/simulated_sequence.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using client_agent::DescribeCamera;
using client_agent::FrameReader;
using client_agent::ImuBetween;
using client_agent::MeasureTimes;
using client_agent::SourceDescription;
using client_agent::SourceFindings;

namespace {

class SimReader : public FrameReader {
 public:
  SimReader(std::unique_ptr<SimulatedSequence> sequence, SourceDescription description)
      : sequence_(std::move(sequence)), description_(std::move(description)) {}

  const SensorCalibration& calibration() const override { return sequence_->calibration(); }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return sequence_->frame_count(); }
  int64_t timestamp_ns(size_t frame) const override { return sequence_->timestamp_ns(frame); }
  int drive(size_t /*frame*/) const override { return 0; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    return sequence_->Render(frame);
  }
  ImuSamples Imu(int64_t after_ns, int64_t until_ns) const override {
    return ImuBetween(sequence_->imu(), after_ns, until_ns);
  }

 private:
  const std::unique_ptr<SimulatedSequence> sequence_;
  const SourceDescription description_;
};

SourceDescription Describe(const SimulatedSequence& sequence) {
  const std::string from = "the simulation";
  SourceDescription description;
  description.layout = "simulation";
  DescribeCamera(sequence.calibration(), description);
  description.intrinsics_from = from;
  description.depth_units_from = from;
  description.times_from = from;
  const auto imu =
      std::visit([](const auto& sensor) { return sensor.imu; }, sequence.calibration());
  if (imu.has_value()) {
    const std::string& file = sequence.spec().imu.file;
    description.imu =
        absl::StrCat(FormatReal(imu->rate_hz), " Hz, from ", file.empty() ? from : file);
  }
  description.frames = sequence.frame_count();
  std::vector<int64_t> times_ns;
  for (size_t i = 0; i < sequence.frame_count(); ++i) times_ns.push_back(sequence.timestamp_ns(i));
  // The user may ask for a slow camera: what looks odd in a recording is as wished here.
  SourceFindings ignored;
  const auto times = MeasureTimes("simulation", times_ns, ignored);
  if (times.ok()) description.times = *times;
  return description;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenSimulation(const SimulationSpec& spec) {
  ASSIGN_OR_RETURN(std::unique_ptr<SimulatedSequence> sequence, SimulatedSequence::Make(spec));
  SourceDescription description = Describe(*sequence);
  return std::make_unique<SimReader>(std::move(sequence), std::move(description));
}

}  // namespace corbslam::services
