#include "services/observe/metrics/backup_collector.h"

#include <gtest/gtest.h>

#include "services/observe/metrics/testing/metric_values.h"

namespace corbslam::services {

using map_store::BackupCounts;
using map_store::ScrubCounts;

namespace {

using testing::ValueOf;

TEST(BackupCollectorTest, SaysWhatTheKeeperAndTheScrubSay) {
  const BackupCollector collector(
      [] {
        BackupCounts counts;
        counts.made = 3;
        counts.failed = 2;
        counts.failing = {{"lab", "no room"}};
        counts.all_safe_at = absl::FromUnixSeconds(1000);
        return counts;
      },
      absl::Hours(1),
      [] {
        ScrubCounts counts;
        counts.bytes = 77;
        counts.damaged = 1;
        return counts;
      },
      [] {
        BackupCollector::Health health;
        health.shelf = {2, 3, absl::FromUnixSeconds(500)};
        health.verification = {88, 4};
        return health;
      });
  const auto metrics = collector.Collect();
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_total", {{"outcome", "made"}}), 3);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_total", {{"outcome", "failed"}}), 2);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_failing", {}), 1);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_safe_time_seconds", {}), 1000);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_interval_seconds", {}), 3600);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_damaged", {}), 2);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_unverified", {}), 3);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_verified_time_seconds", {}), 500);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_verified_bytes_total", {}), 88);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_verify_rounds_total", {}), 4);
  EXPECT_EQ(ValueOf(metrics, "corbslam_scrubbed_bytes_total", {}), 77);
  EXPECT_EQ(ValueOf(metrics, "corbslam_scrub_damaged_total", {}), 1);
}

TEST(BackupCollectorTest, AStoreWithoutBackupsSaysSo) {
  const auto metrics = BackupCollector(nullptr, absl::ZeroDuration(), nullptr).Collect();
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_interval_seconds", {}), 0);
  EXPECT_EQ(ValueOf(metrics, "corbslam_backups_safe_time_seconds", {}), 0);
}

}  // namespace
}  // namespace corbslam::services
