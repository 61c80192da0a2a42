#include "services/observe/metrics/credential_collector.h"

#include "absl/time/time.h"
#include "services/observe/metrics/families.h"
#include "services/security/credential_watch.h"

namespace corbslam::services {

std::vector<prometheus::MetricFamily> CredentialCollector::Collect() const {
  Families families;
  for (const CredentialState& state : CredentialStates()) {
    const MetricLabels labels = {{"file", ToString(state.credential)}};
    const bool has_end = state.credential == Credential::kCertificate ||
                         state.credential == Credential::kAuthorities;
    if (has_end) {
      families.Gauge("corbslam_certificate_end_time_seconds",
                     "When the first certificate of the file ends, since 1970; 0: there is none.",
                     state.expires < absl::InfiniteFuture()
                         ? absl::ToDoubleSeconds(state.expires - absl::UnixEpoch())
                         : 0,
                     labels);
    }
    families.Counter("corbslam_credentials_taken_total",
                     "New contents of the file that were taken while the program ran.",
                     static_cast<double>(state.taken), labels);
    families.Gauge("corbslam_credentials_refused",
                   "1 while the file can't be used, and what was read before stays in force.",
                   state.refused ? 1 : 0, labels);
  }
  return families.Take();
}

}  // namespace corbslam::services
