#include "services/observe/adjustment_files/saving_fusion_worker.h"

#include <glog/logging.h>

#include <atomic>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/observe/adjustment_files/adjustment_file.h"

namespace corbslam::services {
namespace {

class SavingFusionWorker : public FusionWorker {
 public:
  SavingFusionWorker(FusionWorker* worker, std::string folder)
      : worker_(*worker), folder_(std::move(folder)) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    return worker_.VerifyOverlap(request, progress);
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override {
    return worker_.FuseMaps(request, progress);
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    const absl::Status saved = WriteAdjustment(request, NextPath());
    if (!saved.ok()) LOG(WARNING) << saved;
    return worker_.AdjustBundle(request, progress);
  }
  absl::StatusOr<LocateFrameResult> LocateFrame(const LocateFrameRequest& request,
                                                const ProgressCallback& progress) override {
    return worker_.LocateFrame(request, progress);
  }
  absl::StatusOr<ExtractFeaturesResult> ExtractFeatures(
      const ExtractFeaturesRequest& request) override {
    return worker_.ExtractFeatures(request);
  }

 private:
  std::string NextPath() {
    const std::string time = absl::FormatTime("%Y%m%dT%H%M%E3SZ", absl::Now(), absl::UTCTimeZone());
    return absl::StrCat(folder_, "/", time, "_", absl::StrFormat("%06d", ++saved_), ".adjustment");
  }

  FusionWorker& worker_;
  const std::string folder_;
  std::atomic<int> saved_ = 0;
};

}  // namespace

std::unique_ptr<FusionWorker> MakeSavingFusionWorker(FusionWorker* worker, std::string folder) {
  return std::make_unique<SavingFusionWorker>(worker, std::move(folder));
}

}  // namespace corbslam::services
