// What readers have in common that play another one's frames with something changed.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_ALTERED_READER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_ALTERED_READER_H_

#include <memory>
#include <utility>

#include "client_agent/source/frame_reader.h"

namespace corbslam::client_agent {

// Frames, times, drives and what the IMU measured are the other reader's; calibration and
// description are, too, unless the constructor of a derived class changes them.
class AlteredReader : public FrameReader {
 public:
  const SensorCalibration& calibration() const override { return calibration_; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return reader_->frame_count(); }
  int64_t timestamp_ns(size_t frame) const override { return reader_->timestamp_ns(frame); }
  int drive(size_t frame) const override { return reader_->drive(frame); }
  ImuSamples Imu(int64_t after_ns, int64_t until_ns) const override {
    return reader_->Imu(after_ns, until_ns);
  }

 protected:
  explicit AlteredReader(std::unique_ptr<FrameReader> reader)
      : calibration_(reader->calibration()),
        description_(reader->description()),
        reader_(std::move(reader)) {}

  const FrameReader& reader() const { return *reader_; }

  SensorCalibration calibration_;
  SourceDescription description_;

 private:
  const std::unique_ptr<FrameReader> reader_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_ALTERED_READER_H_
