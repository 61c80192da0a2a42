#include "services/observe/metrics/measured_fusion_worker.h"

#include <gtest/gtest.h>

#include "services/observe/metrics/testing/metric_values.h"

namespace corbslam::services {
namespace {

using testing::ValueOf;

// Reads the metrics while it works; it fuses nothing.
class InspectingWorker : public FusionWorker {
 public:
  explicit InspectingWorker(prometheus::Registry* registry) : registry_(*registry) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback&) override {
    running_ =
        ValueOf(registry_.Collect(), "corbslam_fusion_requests_running", {{"kind", "verify"}});
    return VerifyOverlapResult{.base_revision = request.base_revision, .overlaps = {}};
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest&,
                                          const ProgressCallback&) override {
    return absl::UnavailableError("no worker");
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest&,
                                                  const ProgressCallback&) override {
    return AdjustBundleResult();
  }

  std::optional<double> running_;

 private:
  prometheus::Registry& registry_;
};

TEST(MeasuredFusionWorkerTest, RequestsAreCountedByKindAndEnd) {
  prometheus::Registry registry;
  InspectingWorker inner(&registry);
  const auto worker = MakeMeasuredFusionWorker(&inner, registry);
  VerifyOverlapRequest request;
  request.base_revision = 7;
  EXPECT_EQ(worker->VerifyOverlap(request, {})->base_revision, 7u);
  EXPECT_TRUE(worker->VerifyOverlap({}, {}).ok());
  EXPECT_EQ(worker->FuseMaps({}, {}).status(), absl::UnavailableError("no worker"));
  EXPECT_EQ(inner.running_, 1);
  const auto families = registry.Collect();
  const auto requests = [&families](const char* kind, const char* code) {
    return ValueOf(families, "corbslam_fusion_requests_total", {{"kind", kind}, {"code", code}});
  };
  EXPECT_EQ(requests("verify", "OK"), 2);
  EXPECT_EQ(requests("fuse", "UNAVAILABLE"), 1);
  EXPECT_EQ(requests("fuse", "OK"), 0);
  EXPECT_EQ(requests("adjust", "OK"), 0) << "there, so that rates begin at zero";
  EXPECT_EQ(ValueOf(families, "corbslam_fusion_requests_running", {{"kind", "verify"}}), 0);
  EXPECT_EQ(ValueOf(families, "corbslam_fusion_request_duration_seconds", {{"kind", "verify"}}), 2);
}

}  // namespace
}  // namespace corbslam::services
