#include "services/observe/metrics/disk_collector.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace corbslam::services {
namespace {

TEST(DiskCollectorTest, SaysHowMuchRoomFoldersHave) {
  const std::string here = std::filesystem::temp_directory_path().string();
  const DiskCollector collector(
      {{"journal", here, 1000}, {"backups", here + "/is/not/there/yet"}, {"spool", ""}});
  const std::vector<prometheus::MetricFamily> families = collector.Collect();
  ASSERT_EQ(families.size(), 3u);
  EXPECT_EQ(families[0].name, "corbslam_disk_free_bytes");
  ASSERT_EQ(families[0].metric.size(), 2u) << "without a folder there is no room";
  EXPECT_EQ(families[0].metric[0].label[0].value, "journal");
  EXPECT_EQ(families[0].metric[1].label[0].value, "backups");
  EXPECT_GT(families[0].metric[0].gauge.value, 0);
  EXPECT_GE(families[1].metric[0].gauge.value, families[0].metric[0].gauge.value);
  EXPECT_EQ(families[1].metric[1].gauge.value, families[1].metric[0].gauge.value);
  EXPECT_EQ(families[2].metric[0].gauge.value, 1000);
}

}  // namespace
}  // namespace corbslam::services
