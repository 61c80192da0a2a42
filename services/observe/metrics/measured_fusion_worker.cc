#include "services/observe/metrics/measured_fusion_worker.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>

#include <string>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/observe/metrics/buckets.h"

namespace corbslam::services {
namespace {

// Holds the three families, which the kinds of requests share.
struct RequestFamilies {
  explicit RequestFamilies(prometheus::Registry& registry)
      : requests(prometheus::BuildCounter()
                     .Name("corbslam_fusion_requests_total")
                     .Help("Requests to a fusion worker that ended, by kind and status code.")
                     .Register(registry)),
        running(prometheus::BuildGauge()
                    .Name("corbslam_fusion_requests_running")
                    .Help("Requests that a fusion worker has now.")
                    .Register(registry)),
        durations(prometheus::BuildHistogram()
                      .Name("corbslam_fusion_request_duration_seconds")
                      .Help("From a request to its result; in a store with the way there and back.")
                      .Register(registry)) {}

  prometheus::Family<prometheus::Counter>& requests;
  prometheus::Family<prometheus::Gauge>& running;
  prometheus::Family<prometheus::Histogram>& durations;
};

// Counts and times requests of one kind.
class Kind {
 public:
  Kind(const RequestFamilies& families, const std::string& name)
      : name_(name),
        requests_(families.requests),
        running_(families.running.Add({{"kind", name}})),
        duration_(families.durations.Add({{"kind", name}}, LongTimes_s())) {
    Count(absl::StatusCode::kOk, 0);
  }

  template <typename Work>
  auto Measure(const Work& work) {
    running_.Increment();
    const absl::Time start = absl::Now();
    auto result = work();
    duration_.Observe(absl::ToDoubleSeconds(absl::Now() - start));
    running_.Decrement();
    Count(result.status().code(), 1);
    return result;
  }

 private:
  void Count(absl::StatusCode code, double by) {
    requests_.Add({{"kind", name_}, {"code", absl::StatusCodeToString(code)}}).Increment(by);
  }

  const std::string name_;
  prometheus::Family<prometheus::Counter>& requests_;
  prometheus::Gauge& running_;
  prometheus::Histogram& duration_;
};

class MeasuredFusionWorker : public FusionWorker {
 public:
  MeasuredFusionWorker(FusionWorker* worker, prometheus::Registry& registry)
      : worker_(*worker),
        families_(registry),
        verify_(families_, "verify"),
        fuse_(families_, "fuse"),
        adjust_(families_, "adjust"),
        locate_(families_, "locate"),
        extract_(families_, "extract") {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    return verify_.Measure([&] { return worker_.VerifyOverlap(request, progress); });
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override {
    return fuse_.Measure([&] { return worker_.FuseMaps(request, progress); });
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    return adjust_.Measure([&] { return worker_.AdjustBundle(request, progress); });
  }
  absl::StatusOr<LocateFrameResult> LocateFrame(const LocateFrameRequest& request,
                                                const ProgressCallback& progress) override {
    return locate_.Measure([&] { return worker_.LocateFrame(request, progress); });
  }
  absl::StatusOr<ExtractFeaturesResult> ExtractFeatures(
      const ExtractFeaturesRequest& request) override {
    return extract_.Measure([&] { return worker_.ExtractFeatures(request); });
  }

 private:
  FusionWorker& worker_;
  const RequestFamilies families_;
  Kind verify_;
  Kind fuse_;
  Kind adjust_;
  Kind locate_;
  Kind extract_;
};

}  // namespace

std::unique_ptr<FusionWorker> MakeMeasuredFusionWorker(FusionWorker* worker,
                                                       prometheus::Registry& registry) {
  return std::make_unique<MeasuredFusionWorker>(worker, registry);
}

}  // namespace corbslam::services
