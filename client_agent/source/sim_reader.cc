#include <memory>
#include <utility>

#include "client_agent/source/frame_reader.h"
#include "slam/simulation/sequence/simulated_sequence.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

class SimReader : public FrameReader {
 public:
  explicit SimReader(std::unique_ptr<SimulatedSequence> sequence)
      : sequence_(std::move(sequence)) {}

  const SensorCalibration& calibration() const override { return sequence_->calibration(); }
  size_t frame_count() const override { return sequence_->frame_count(); }
  int64_t timestamp_ns(size_t frame) const override { return sequence_->timestamp_ns(frame); }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    return sequence_->Render(frame);
  }

 private:
  const std::unique_ptr<SimulatedSequence> sequence_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenSimulation(const SimulationSpec& spec) {
  ASSIGN_OR_RETURN(std::unique_ptr<SimulatedSequence> sequence, SimulatedSequence::Make(spec));
  return std::make_unique<SimReader>(std::move(sequence));
}

}  // namespace corbslam
