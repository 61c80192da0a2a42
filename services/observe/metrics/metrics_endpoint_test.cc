#include "services/observe/metrics/metrics_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/counter.h>
#include <prometheus/registry.h>

#include <memory>
#include <string>
#include <vector>

#include "services/http/testing/raw_http.h"
#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/testing/metric_values.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
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

TEST(MetricsEndpointTest, RefusesWhatIsNoAddress) {
  for (const char* address : {"", "9464", ":9464", "127.0.0.1", "127.0.0.1:x", "127.0.0.1:65536",
                              "127.0.0.1:1,0.0.0.0:9464", "127.0.0.1:9464s", "+9464"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(MetricsEndpoint::Start(address, {}).status())) << address;
  }
}

class ServedMetricsTest : public ::testing::Test {
 protected:
  ServedMetricsTest() {
    auto endpoint = MetricsEndpoint::Start(
        "127.0.0.1:0", {registry_, std::make_shared<ProcessCollector>("map_store")});
    EXPECT_TRUE(endpoint.ok()) << endpoint.status();
    endpoint_ = *std::move(endpoint);
    prometheus::BuildCounter()
        .Name("rain_total")
        .Help("Drops")
        .Register(*registry_)
        .Add({})
        .Increment(3);
  }
  std::string Ask(const char* method, const char* target) const {
    return testing::Ask(endpoint_->address(), testing::MakeRequest(method, target));
  }

  const std::shared_ptr<prometheus::Registry> registry_ = std::make_shared<prometheus::Registry>();
  std::unique_ptr<MetricsEndpoint> endpoint_;
};

TEST_F(ServedMetricsTest, AreTextOfAllCollectables) {
  const std::string answer = Ask("GET", "/metrics");
  EXPECT_EQ(testing::StatusOf(answer), 200);
  EXPECT_THAT(answer, AllOf(HasSubstr("Content-Type: text/plain; charset=utf-8\r\n"),
                            HasSubstr("# HELP rain_total Drops\n# TYPE rain_total counter\n"),
                            HasSubstr("\nrain_total 3\n"), HasSubstr("corbslam_build_info{")));
  EXPECT_EQ(testing::StatusOf(Ask("GET", "/metrics?name=x")), 200);
  const std::string head = Ask("HEAD", "/metrics");
  EXPECT_EQ(testing::StatusOf(head), 200);
  EXPECT_EQ(testing::BodyOf(head), "");
}

TEST_F(ServedMetricsTest, OtherPathsAreNotThere) {
  for (const char* path : {"/", "/metric", "/metrics/", "/METRICS", "//metrics", "/favicon.ico",
                           "/metrics/../metrics"}) {
    EXPECT_EQ(testing::StatusOf(Ask("GET", path)), 404) << path;
    EXPECT_EQ(testing::StatusOf(Ask("HEAD", path)), 404) << path;
  }
}

TEST_F(ServedMetricsTest, OtherMethodsAreRefusedWithThoseThatThereAre) {
  for (const char* method :
       {"POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "get"}) {
    const std::string answer = Ask(method, "/metrics");
    EXPECT_EQ(testing::StatusOf(answer), 405) << method;
    EXPECT_THAT(answer, HasSubstr("Allow: GET, HEAD\r\n")) << method;
  }
  EXPECT_EQ(testing::StatusOf(Ask("OPTIONS", "*")), 405);
}

TEST_F(ServedMetricsTest, AreReadBesideManyWhoSayNothing) {
  std::vector<testing::RawConnection> silent;
  for (int i = 0; i < 300; ++i) silent.emplace_back(endpoint_->address());
  EXPECT_EQ(testing::StatusOf(Ask("GET", "/metrics")), 200);
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
}  // namespace corbslam::services
