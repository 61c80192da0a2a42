// The robot's flags about recording what it tracks (docs/recording.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORD_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORD_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "services/programs/recording/frame_recorder.h"
#include "services/programs/robot/paced_stream.h"
#include "services/programs/robot/robot_source.h"

namespace corbslam::services {

struct RecordFlags {
  std::string folder;  // Empty: nothing is recorded.
  uint64_t waiting_mb = 128;
};

void AddRecordFlags(CLI::App& app, RecordFlags& flags);
// Returns what StartRecording would refuse; changes nothing.
absl::Status CheckRecording(const RecordFlags& flags);

// What decides a run, apart from its frames.
struct RunToRecord {
  const client_agent::AgentOptions& agent;
  std::string source;  // As the user named it.
  Pace pace = Pace::kMax;
  bool joined = false;      // To a map store.
  uint64_t vocabulary = 0;  // Vocabulary::fingerprint.
};

// Returns null without --record. At kMax a recording that is played waits for the disk; cameras and
// robots at the sensor's pace never do.
absl::StatusOr<std::unique_ptr<FrameRecorder>> StartRecording(
    const RecordFlags& flags, const RunToRecord& run, const client_agent::FrameStream& stream);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORD_FLAGS_H_
