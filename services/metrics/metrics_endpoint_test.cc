#include "services/metrics/metrics_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/metrics/process_collector.h"
#include "services/metrics/testing/metric_values.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

TEST(MetricsEndpointTest, ChoosesAPort) {
  const auto endpoint = MetricsEndpoint::Start("127.0.0.1:0", {});
  ASSERT_TRUE(endpoint.ok()) << endpoint.status();
  EXPECT_THAT((*endpoint)->address(), MatchesRegex("127.0.0.1:[1-9][0-9]*"));
}

TEST(MetricsEndpointTest, ATakenPortIsSaid) {
  const auto first = MetricsEndpoint::Start("127.0.0.1:0", {});
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = MetricsEndpoint::Start((*first)->address(), {});
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()), HasSubstr((*first)->address()));
}

TEST(MetricsEndpointTest, RefusesWhatTheHttpServerWouldTakeForSomethingElse) {
  for (const char* address : {"", "9464", ":9464", "127.0.0.1", "127.0.0.1:x", "127.0.0.1:65536",
                              "127.0.0.1:1,0.0.0.0:9464", "127.0.0.1:9464s", "+9464"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(MetricsEndpoint::Start(address, {}).status())) << address;
  }
}

TEST(ProcessCollectorTest, SaysWhatTheProcessUses) {
  const ProcessCollector collector("map_store");
  const auto families = collector.Collect();
  EXPECT_GT(testing::ValueOf(families, "process_resident_memory_bytes"), 1e6);
  EXPECT_GT(testing::ValueOf(families, "process_open_fds"), 2);
  EXPECT_GT(testing::ValueOf(families, "process_start_time_seconds"), 1.7e9);
  EXPECT_GE(testing::ValueOf(families, "process_cpu_seconds_total"), 0);
}

}  // namespace
}  // namespace corbslam
