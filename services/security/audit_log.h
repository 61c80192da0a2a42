// Writes down who did what: administrative calls, sessions, and everything that was refused.
#ifndef CORBSLAM_SERVICES_SECURITY_AUDIT_LOG_H_
#define CORBSLAM_SERVICES_SECURITY_AUDIT_LOG_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "services/security/access_control.h"
#include "services/security/audit_file.h"
#include "services/security/refusal_limiter.h"
#include "services/server/call_auditor.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::services {

// Why a call was refused.
enum class RefusalKind { kUnauthenticated, kPermissionDenied, kResourceExhausted, kInvalidSession };
inline constexpr RefusalKind kRefusalKinds[] = {
    RefusalKind::kUnauthenticated, RefusalKind::kPermissionDenied, RefusalKind::kResourceExhausted,
    RefusalKind::kInvalidSession};
// Returns "unauthenticated", "permission_denied", "resource_exhausted" or "invalid_session".
std::string ToString(RefusalKind kind);
// Returns nullopt for a call that was not refused: it went well, or failed for another reason.
std::optional<RefusalKind> RefusalOf(absl::string_view method, absl::StatusCode code);

// What a server's calls were refused for, and what became of the lines about calls. Thread-safe.
struct AuditCounts {
  std::array<std::atomic<uint64_t>, std::size(kRefusalKinds)> refused = {};
  std::atomic<uint64_t> written{0};
  std::atomic<uint64_t> left_out{0};  // Beyond a peer's limit.
  std::atomic<uint64_t> failed{0};    // The disk was full, or the like.
};
// Returns those of all servers of this process.
AuditCounts& ProcessAuditCounts();

struct AuditLogOptions {
  // Where lines go: a file, "-" for the program's log, or nowhere if it is empty (then refusals are
  // counted only).
  std::string file;
  uint64_t max_bytes = 64u << 20;
  // Refusals that are written for one host in a minute.
  size_t refusals_a_minute = 60;
};

// Writes a JSON object a line (docs/security.md has its fields). What callers say is shortened, and
// escaped. Nothing it does keeps a call from its answer but the writing of a line. Thread-safe.
class AuditLog : public CallAuditor {
 public:
  // Null access: nobody has an identity. INVALID_ARGUMENT if the file can't be opened.
  static absl::StatusOr<std::shared_ptr<AuditLog>> Open(
      const AuditLogOptions& options, std::shared_ptr<const AccessControl> access);
  // Says what was left out in the last minute.
  ~AuditLog() override;

  std::string OnAsked(absl::string_view method, const grpc::ServerContextBase& context,
                      const void* message) override;
  void OnEnded(const EndedCall& call) override;
  void OnOwnDoing(absl::string_view event, absl::string_view resource,
                  absl::string_view why) override ABSL_LOCKS_EXCLUDED(mutex_);
  // The call gate refused a call. It is not told the caller's address.
  void OnTurnedAway(absl::string_view method, const Evidence& evidence,
                    absl::string_view user_agent, const absl::Status& status);

 private:
  // What a line says.
  struct Line {
    const char* event = "";
    std::string peer;
    Evidence evidence;
    std::string user_agent;
    std::string method;
    std::string resource;
    std::optional<absl::Status> answer;
  };

  AuditLog(const AuditLogOptions& options, std::shared_ptr<const AccessControl> access)
      : options_(options), access_(std::move(access)), limiter_(options.refusals_a_minute) {}

  std::string ToJson(const Line& line, absl::Time now) const;
  void WriteRefusal(RefusalKind kind, const Line& line) ABSL_LOCKS_EXCLUDED(mutex_);
  void Write(const Line& line) ABSL_LOCKS_EXCLUDED(mutex_);
  void SayWhatWasLeftOut(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void WriteText(const std::string& json) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const AuditLogOptions options_;
  const std::shared_ptr<const AccessControl> access_;
  absl::Mutex mutex_;
  RefusalLimiter limiter_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<AuditFile> file_ ABSL_GUARDED_BY(mutex_);
  RareReminder failing_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_AUDIT_LOG_H_
