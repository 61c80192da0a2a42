#include "map_store/mission/mission_summary.h"

#include "map_store/archive/archive.h"
#include "map_store/archive/state_fields.h"

namespace corbslam::map_store {

namespace {

// Grows with each change of the fields below: a summary of another format is not used, and the
// mission is read instead.
constexpr uint32_t kSummaryFormat = 4;

}  // namespace

template <typename Archive, MayBeConst<FusionRequestCounts> T>
void Fields(Archive& archive, T& counts) {
  archive(counts.verify, counts.fuse, counts.adjust);
}

template <typename Archive, MayBeConst<MissionInfo> T>
void Fields(Archive& archive, T& info) {
  archive(info.name, info.revision, info.agents, info.local_maps, info.islands, info.keyframes,
          info.map_points, info.fusion_idle, info.waiting_queries, info.memory_bytes, info.profile);
  SettingsFields(archive, info.profile);
  archive(info.uid);
}

template <typename Archive, MayBeConst<MissionLoad> T>
void Fields(Archive& archive, T& load) {
  archive(load.mission, load.revision, load.agents, load.local_maps, load.islands, load.keyframes,
          load.map_points, load.overlaps_queried, load.overlaps_verified, load.overlaps_accepted,
          load.failed_requests, load.waiting, load.written_s, load.longest_write_s,
          load.joined_local_maps, load.forgotten_local_maps, load.retired_keyframes,
          load.faded_points);
}

template <typename Archive, MayBeConst<MissionSummary> T>
void Fields(Archive& archive, T& summary) {
  archive(summary.info, summary.load, summary.work_left, summary.retired);
}

std::string EncodeSummary(const MissionSummary& summary) {
  ArchiveWriter writer;
  writer(kSummaryFormat, summary);
  return writer.Take();
}

absl::StatusOr<MissionSummary> DecodeSummary(absl::string_view bytes) {
  ArchiveReader reader(std::string_view(bytes.data(), bytes.size()));
  uint32_t format = 0;
  reader(format);
  if (!reader.ok() || format != kSummaryFormat) {
    return absl::DataLossError("a mission's summary has a format that this program doesn't read");
  }
  MissionSummary summary;
  reader(summary);
  if (!reader.done()) return absl::DataLossError("a mission's summary is damaged");
  return summary;
}

}  // namespace corbslam::map_store
