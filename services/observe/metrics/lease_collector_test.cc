#include "services/observe/metrics/lease_collector.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "map_store/testing/told_directory.h"

namespace corbslam::services {
namespace {

class CountedLeases : public testing::JournalOfToldDirectory {
 public:
  CountedLeases() : JournalOfToldDirectory(&directory_) {}
  map_store::FleetCounts counts() const override { return counts_; }

  testing::ToldDirectory directory_;
  map_store::FleetCounts counts_;
};

std::map<std::string, double> Read(const map_store::MissionLeases* leases) {
  std::map<std::string, double> values;
  for (const prometheus::MetricFamily& family : LeaseCollector(leases).Collect()) {
    for (const prometheus::ClientMetric& metric : family.metric) {
      const std::string label = metric.label.empty() ? "" : "/" + metric.label[0].value;
      values[family.name + label] = metric.gauge.value + metric.counter.value;
    }
  }
  return values;
}

TEST(LeaseCollectorTest, AStoreThatSharesNothingSaysNothing) { EXPECT_TRUE(Read(nullptr).empty()); }

TEST(LeaseCollectorTest, SaysWhatIsCounted) {
  CountedLeases leases;
  leases.counts_ = {.held = 5,
                    .given = 7,
                    .given_to_balance = 3,
                    .lost = 2,
                    .refused_writes = 1,
                    .reaches_database = false,
                    .unreached = 9,
                    .busy_pool = 4};
  auto values = Read(&leases);
  EXPECT_EQ(values.at("corbslam_leases_held"), 5);
  EXPECT_EQ(values.at("corbslam_leases_lost_total"), 2);
  EXPECT_EQ(values.at("corbslam_writes_refused_total"), 1);
  EXPECT_EQ(values.at("corbslam_missions_given_total/balance"), 3);
  EXPECT_EQ(values.at("corbslam_missions_given_total/asked"), 4);
  EXPECT_EQ(values.at("corbslam_database_reached"), 0);
  EXPECT_EQ(values.at("corbslam_database_unreached_total"), 9);
  EXPECT_EQ(values.at("corbslam_database_pool_busy_total"), 4);
  EXPECT_EQ(values.count("corbslam_database_standbys_wanted"), 0u);
  EXPECT_EQ(values.count("corbslam_store_load"), 0u);
  leases.counts_.standbys = map_store::StandbyCounts{2, 1};
  leases.counts_.load = map_store::StoreLoad{1, 4, 0, 0, 0};
  values = Read(&leases);
  EXPECT_EQ(values.at("corbslam_database_standbys_wanted"), 2);
  EXPECT_EQ(values.at("corbslam_database_standbys_there"), 1);
  EXPECT_EQ(values.at("corbslam_store_load"), 0.25);
}

}  // namespace
}  // namespace corbslam::services
