#include "services/tool/commands/recorded_notes.h"

#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "services/client/store/local_map_names.h"
#include "services/convert/resource_names.h"
#include "services/tool/mission/event_text.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr uint64_t kInTheEnd = std::numeric_limits<uint64_t>::max();

bool IsAccepted(const v1::Overlap& overlap) {
  return overlap.verdict() == v1::OVERLAP_VERDICT_ACCEPTED;
}

// Returns "alpha/1 keyframe 12".
std::string ShortKeyframe(const std::string& keyframe, const LocalMapNames& names) {
  const std::string local_map = keyframe.substr(0, keyframe.find("/keyframes/"));
  const auto name = names.find(local_map);
  return absl::StrCat(name == names.end() ? LastSegment(local_map) : name->second, " keyframe ",
                      LastSegment(keyframe));
}

RecordedNote NoteOf(const v1::Overlap& overlap, const LocalMapNames& names) {
  std::string text =
      absl::StrCat("overlap ", overlap.number(), ", ", ShortKeyframe(overlap.query(), names),
                   " with ", ShortKeyframe(overlap.candidate(), names), ": ");
  if (IsAccepted(overlap)) {
    absl::StrAppend(&text, "accepted, ", overlap.inliers(), " inliers");
    if (overlap.revision() == 0) absl::StrAppend(&text, ", in no revision yet");
  } else {
    absl::StrAppend(&text, "refused, ", DescribeVerdict(overlap.verdict()));
  }
  if (!overlap.note().empty()) absl::StrAppend(&text, " (", overlap.note(), ")");
  const bool has_revision = IsAccepted(overlap) && overlap.revision() != 0;
  return {has_revision ? overlap.revision() : kInTheEnd,
          overlap.verdict() == v1::OVERLAP_VERDICT_TAKEN_BACK, text};
}

}  // namespace

absl::StatusOr<std::vector<RecordedOverlap>> AcceptedOverlaps(const MissionSummary& summary) {
  std::vector<RecordedOverlap> accepted;
  for (const v1::Overlap& overlap : summary.overlaps) {
    if (!IsAccepted(overlap)) continue;
    ASSIGN_OR_RETURN(const KeyframePath query, ParseKeyframeName(overlap.query()));
    ASSIGN_OR_RETURN(const KeyframePath candidate, ParseKeyframeName(overlap.candidate()));
    accepted.push_back({query.keyframe, candidate.keyframe, overlap.revision()});
  }
  return accepted;
}

std::vector<RecordedNote> NotesOfOverlaps(const MissionSummary& summary) {
  const LocalMapNames names = ShortNames(summary.local_maps);
  std::vector<RecordedNote> notes;
  for (const v1::Overlap& overlap : summary.overlaps) notes.push_back(NoteOf(overlap, names));
  return notes;
}

std::vector<RecordedNote> NotesOfEvents(const std::vector<v1::MissionEvent>& events,
                                        const MissionSummary& summary) {
  const LocalMapNames names = ShortNames(summary.local_maps);
  std::vector<RecordedNote> notes;
  for (const v1::MissionEvent& event : events) {
    if (event.missed() > 0) {
      notes.push_back({event.revision(), /*is_warning=*/true,
                       absl::StrCat(event.missed(), " events are not remembered any more")});
    }
    const std::string time = absl::FormatTime(
        "%Y-%m-%d %H:%M:%E3S UTC, ", absl::FromUnixNanos(event.time_ns()), absl::UTCTimeZone());
    notes.push_back({event.revision(), IsWarning(event), time + DescribeEvent(event, names)});
  }
  return notes;
}

}  // namespace corbslam::services
