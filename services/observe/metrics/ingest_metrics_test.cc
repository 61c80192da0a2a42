#include "services/observe/metrics/ingest_metrics.h"

#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "services/observe/metrics/testing/metric_values.h"

namespace corbslam::services {
namespace {

using testing::LabelMap;
using testing::SumOf;
using testing::ValueOf;

const SessionAgent kAlpha{"lab", "alpha"};
const LabelMap kAlphaLabels{{"mission", "lab"}, {"agent", "alpha"}};

class IngestMetricsTest : public ::testing::Test {
 protected:
  testing::MetricFamilies Agents(const std::set<std::string>& missions) {
    Families families;
    metrics_.AddAgents(missions, families);
    return families.Take();
  }

  absl::Time now_ = absl::FromUnixSeconds(1'700'000'000);
  prometheus::Registry registry_;
  IngestMetrics metrics_{registry_, [this] { return now_; }};
};

TEST_F(IngestMetricsTest, BatchesWaitUntilTheyAreAcknowledgedOrRefused) {
  MapUpdateBatch batch;
  batch.full_keyframes.resize(3);
  metrics_.OnOpened(kAlpha);
  metrics_.OnBatch(kAlpha, batch);
  EXPECT_EQ(ValueOf(registry_.Collect(), "corbslam_batches_waiting"), 1);
  metrics_.OnApplied(kAlpha, batch, absl::Milliseconds(20), absl::OkStatus());
  metrics_.OnBatch(kAlpha, batch);
  metrics_.OnApplied(kAlpha, batch, absl::Seconds(9), absl::ResourceExhaustedError("full"));
  const auto families = registry_.Collect();
  EXPECT_EQ(ValueOf(families, "corbslam_batches_waiting"), 0);
  EXPECT_EQ(ValueOf(families, "corbslam_batches_total", {{"code", "OK"}}), 1);
  EXPECT_EQ(ValueOf(families, "corbslam_batches_total", {{"code", "RESOURCE_EXHAUSTED"}}), 1);
  EXPECT_EQ(ValueOf(families, "corbslam_acknowledgement_duration_seconds"), 1)
      << "what is refused is not acknowledged";
  EXPECT_DOUBLE_EQ(*SumOf(families, "corbslam_acknowledgement_duration_seconds"), 0.02);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_keyframes_total", kAlphaLabels), 3);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_batches_total", kAlphaLabels), 1);
}

TEST_F(IngestMetricsTest, BytesAreCountedForEachAgent) {
  metrics_.OnOpened(kAlpha);
  metrics_.OnOpened({"lab", "bravo"});
  metrics_.OnReceived(kAlpha, 100);
  metrics_.OnReceived(kAlpha, 11);
  metrics_.OnSent(kAlpha, 7);
  const auto families = Agents({"lab"});
  EXPECT_EQ(ValueOf(families, "corbslam_agent_received_bytes_total", kAlphaLabels), 111);
  EXPECT_EQ(ValueOf(families, "corbslam_agent_sent_bytes_total", kAlphaLabels), 7);
  EXPECT_EQ(ValueOf(families, "corbslam_agent_received_bytes_total",
                    {{"mission", "lab"}, {"agent", "bravo"}}),
            0);
}

TEST_F(IngestMetricsTest, CountsWhatWaitedForALinksBudget) {
  metrics_.OnOpened(kAlpha);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_delayed_bytes_total", kAlphaLabels), 0);
  metrics_.OnShareDelayed(kAlpha, 700, absl::Milliseconds(250));
  metrics_.OnShareDelayed(kAlpha, 300, absl::Seconds(1));
  const auto families = Agents({"lab"});
  EXPECT_EQ(ValueOf(families, "corbslam_agent_delayed_bytes_total", kAlphaLabels), 1000);
  EXPECT_EQ(ValueOf(families, "corbslam_agent_delay_seconds_total", kAlphaLabels), 1.25);
}

TEST_F(IngestMetricsTest, AnAgentsSeriesGoAWhileAfterItsLastSession) {
  metrics_.OnOpened(kAlpha);
  // The agent comes again before its first session is gone.
  metrics_.OnOpened(kAlpha);
  metrics_.OnClosed(kAlpha, absl::AbortedError("fenced"));
  now_ += IngestMetrics::kKeptFor * 2;
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_connected", kAlphaLabels), 1);
  metrics_.OnClosed(kAlpha, absl::OkStatus());
  now_ += IngestMetrics::kKeptFor;
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_connected", kAlphaLabels), 0);
  now_ += absl::Seconds(1);
  EXPECT_TRUE(Agents({"lab"}).empty());
  const auto families = registry_.Collect();
  EXPECT_EQ(ValueOf(families, "corbslam_sessions_ended_total", {{"code", "ABORTED"}}), 1);
  EXPECT_EQ(ValueOf(families, "corbslam_sessions_ended_total", {{"code", "OK"}}), 1);
}

TEST_F(IngestMetricsTest, AnAgentWhoseSessionBrokeIsMissingUntilItComesBack) {
  metrics_.OnOpened(kAlpha);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_missing", kAlphaLabels), 0);
  metrics_.OnClosed(kAlpha, absl::UnavailableError("the line broke"));
  now_ += absl::Hours(24);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_missing", kAlphaLabels), 1);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_connected", kAlphaLabels), 0);
  metrics_.OnOpened(kAlpha);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_missing", kAlphaLabels), 0);
  metrics_.OnClosed(kAlpha, absl::OkStatus());
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_missing", kAlphaLabels), 0);
}

TEST_F(IngestMetricsTest, OfManyMissingAgentsTheNewestAreTold) {
  for (size_t i = 0; i < IngestMetrics::kMostMissing + 10; ++i) {
    const SessionAgent agent{.mission = "lab", .agent = absl::StrCat("robot", i)};
    metrics_.OnOpened(agent);
    metrics_.OnClosed(agent, absl::UnavailableError("the line broke"));
    now_ += absl::Seconds(1);
  }
  now_ += absl::Hours(1);
  const auto families = Agents({"lab"});
  const auto labels = [](size_t i) -> LabelMap {
    return {{"mission", "lab"}, {"agent", absl::StrCat("robot", i)}};
  };
  EXPECT_EQ(ValueOf(families, "corbslam_agent_missing", labels(9)), std::nullopt);
  EXPECT_EQ(ValueOf(families, "corbslam_agent_missing", labels(10)), 1);
  now_ += IngestMetrics::kMissedFor;
  EXPECT_TRUE(Agents({"lab"}).empty());
}

TEST_F(IngestMetricsTest, AnAgentsSeriesGoWithItsMission) {
  metrics_.OnOpened(kAlpha);
  metrics_.OnReceived(kAlpha, 5);
  // The agent's stream has not ended yet.
  EXPECT_TRUE(Agents({"other"}).empty());
  metrics_.OnClosed(kAlpha, absl::AbortedError("mission lab was deleted"));
  EXPECT_TRUE(Agents({"other"}).empty());
  // When the mission is made anew under the same name, nothing is left of the old one.
  metrics_.OnOpened(kAlpha);
  EXPECT_EQ(ValueOf(Agents({"lab"}), "corbslam_agent_received_bytes_total", kAlphaLabels), 0);
}

}  // namespace
}  // namespace corbslam::services
