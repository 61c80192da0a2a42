// Finds what the recording of a mission draws and says of overlaps and events.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_RECORDED_NOTES_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_RECORDED_NOTES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "corbslam/v1/events.pb.h"
#include "services/tool/export/mcap/mission_recording.h"
#include "services/tool/export/mcap/recorded_scene.h"
#include "services/tool/mission/mission_summary.h"

namespace corbslam::services {

// Returns the accepted overlaps. INVALID_ARGUMENT names a keyframe that can't be understood.
absl::StatusOr<std::vector<RecordedOverlap>> AcceptedOverlaps(const MissionSummary& summary);

// Returns a note for each overlap: an accepted one with the revision that took it into the graph,
// all others with the last one, since when they were refused is not told; with the reason.
std::vector<RecordedNote> NotesOfOverlaps(const MissionSummary& summary);
// Returns a note for each event, with its time by the store's clock, and for events that are not
// remembered any more.
std::vector<RecordedNote> NotesOfEvents(const std::vector<v1::MissionEvent>& events,
                                        const MissionSummary& summary);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_RECORDED_NOTES_H_
