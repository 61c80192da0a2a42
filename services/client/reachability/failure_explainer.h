// Explains failures of one server that is asked again and again.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_FAILURE_EXPLAINER_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_FAILURE_EXPLAINER_H_

#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/client/reachability/cause.h"

namespace corbslam::services {

// Keeps what ExplainFailure found out for a while, so that a call that fails every second is not
// probed every second. Thread-safe; one caller probes at a time, and the others wait for it.
class FailureExplainer {
 public:
  explicit FailureExplainer(ServerTarget target, absl::Duration good_for = absl::Seconds(30))
      : target_(std::move(target)), good_for_(good_for) {}

  absl::Status Explain(const absl::Status& seen) {
    absl::MutexLock lock(&mutex_);
    const absl::Time now = absl::Now();
    if (seen == seen_ && now < good_until_) return explained_;
    explained_ = ExplainFailure(target_, seen);
    seen_ = seen;
    good_until_ = now + good_for_;
    return explained_;
  }

 private:
  const ServerTarget target_;
  const absl::Duration good_for_;
  absl::Mutex mutex_;
  absl::Status seen_ ABSL_GUARDED_BY(mutex_);
  absl::Status explained_ ABSL_GUARDED_BY(mutex_);
  absl::Time good_until_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_FAILURE_EXPLAINER_H_
