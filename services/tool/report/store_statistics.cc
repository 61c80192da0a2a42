#include "services/tool/report/store_statistics.h"

namespace corbslam::services {
namespace {

TransferReport FromProto(const v1::TransferCount& proto) {
  return {proto.count(), proto.bytes(), proto.ms()};
}

}  // namespace

void AddStatistics(const v1::MissionStatistics& statistics, RunReport& report) {
  report.fused.islands = statistics.islands_size();
  for (const v1::IslandStatistics& island : statistics.islands()) {
    if (!island.in_global_frame()) continue;
    report.fused.robots = island.agents_size();
    report.fused.keyframes = island.keyframes();
  }
  report.overlaps = {statistics.overlaps_queried(), statistics.overlaps_verified(),
                     statistics.overlaps_accepted()};
  report.merge_ms.assign(statistics.merge_ms().begin(), statistics.merge_ms().end());
  for (const v1::AdjustmentRecord& adjustment : statistics.adjustments()) {
    report.global_ba_ms.push_back({adjustment.keyframes(), adjustment.map_points(),
                                   adjustment.iterations(), adjustment.ms()});
  }
  const v1::TransferStatistics& transfer = statistics.transfer();
  report.full_keyframes = FromProto(transfer.full_keyframes());
  report.full_map_points = FromProto(transfer.full_map_points());
  report.light_keyframes = FromProto(transfer.light_keyframes());
  report.light_map_points = FromProto(transfer.light_map_points());
}

}  // namespace corbslam::services
