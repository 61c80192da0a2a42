#include "services/observe/metrics/security_collector.h"

#include "absl/time/time.h"
#include "services/observe/metrics/families.h"
#include "services/security/audit_log.h"
#include "services/security/credential_watch.h"

namespace corbslam::services {
namespace {

// Returns seconds since 1970; 0: never.
double EndOf(const CredentialState& state) {
  if (state.expires == absl::InfiniteFuture()) return 0;
  return absl::ToDoubleSeconds(state.expires - absl::UnixEpoch());
}

void AddCredential(const CredentialState& state, Families& families) {
  const MetricLabels labels = {{"file", ToString(state.credential)}};
  if (state.credential == Credential::kCertificate ||
      state.credential == Credential::kAuthorities ||
      state.credential == Credential::kWebCertificate) {
    families.Gauge("corbslam_certificate_end_time_seconds",
                   "When the first certificate of the file ends, since 1970; 0: there is none.",
                   EndOf(state), labels);
  }
  families.Counter("corbslam_credentials_taken_total",
                   "New contents of the file that were taken while the program ran.",
                   static_cast<double>(state.taken), labels);
  families.Gauge("corbslam_credentials_refused",
                 "1 while the file can't be used, and what was read before stays in force.",
                 state.refused ? 1 : 0, labels);
}

void AddAudit(const AuditCounts& counts, Families& families) {
  for (const RefusalKind kind : kRefusalKinds) {
    families.Counter("corbslam_refused_calls_total", "Calls that were refused, by why.",
                     static_cast<double>(counts.refused[static_cast<size_t>(kind)]),
                     {{"kind", ToString(kind)}});
  }
  const auto add = [&families](const char* outcome, uint64_t lines) {
    families.Counter("corbslam_audit_lines_total",
                     "Lines of the audit log, by what became of them.", static_cast<double>(lines),
                     {{"outcome", outcome}});
  };
  add("written", counts.written);
  add("left_out", counts.left_out);
  add("failed", counts.failed);
}

}  // namespace

std::vector<prometheus::MetricFamily> SecurityCollector::Collect() const {
  Families families;
  for (const CredentialState& state : CredentialStates()) AddCredential(state, families);
  AddAudit(ProcessAuditCounts(), families);
  return families.Take();
}

}  // namespace corbslam::services
