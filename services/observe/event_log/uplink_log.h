// Writes a robot's sessions with its map store to its log: above all that there is none, and why.
#ifndef CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_UPLINK_LOG_H_
#define CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_UPLINK_LOG_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/observe/logging/log_fields.h"
#include "services/observe/observed_uplink.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::services {

struct UplinkLogOptions {
  // An attempt that takes longer is looked into while it lasts.
  absl::Duration slow_attempt = absl::Seconds(1);
  // A cause that was found stays valid for this long, unless the attempts end otherwise than
  // before.
  absl::Duration explain_again = absl::Seconds(15);
  // The robot makes no map, and so has none of its own meanwhile.
  bool localise_only = false;
  // What ends sooner is no recovery: it is told as seldom as if the session had never stood.
  absl::Duration lasting = absl::Seconds(15);
  std::function<absl::Time()> clock = &absl::Now;
};

// Writes a warning within a second or two after a session was lost or an attempt failed, with the
// cause; again when the cause is another one, and else more and more seldom; and a line once a
// session stands. A thread of its own finds out the causes. Thread-safe.
class UplinkLog : public UplinkObserver {
 public:
  // Finds out why an attempt ended as `seen` says, or does not end (OK). It may block.
  using Explain = std::function<absl::Status(const absl::Status& seen)>;

  UplinkLog(LogFields who, Explain explain, const UplinkLogOptions& options = {});
  // The destructor waits for an explanation that is under way.
  ~UplinkLog() override;

  // Returns OK while a session stands, else why there is none, as far as is known.
  absl::Status status() const;

  void OnOpening() override;
  void OnOpened() override;
  void OnClosed(const absl::Status& reason) override;

 private:
  void Run();
  // Warns of what is known, until there is something to find out, and returns that status; nullopt
  // at the end.
  std::optional<absl::Status> WaitForTrouble();
  void NoteCause(const absl::Status& seen, const absl::Status& cause);
  // Returns true if what is known of the cause is old.
  bool NeedsExplanation() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  // Notes for how long the session stood that has just ended.
  void NoteLength(absl::Duration stood) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::string DescribeShortLived() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  void WarnIfDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const LogFields who_;
  const Explain explain_;
  const UplinkLogOptions options_;

  mutable absl::Mutex mutex_;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  bool connected_ ABSL_GUARDED_BY(mutex_) = false;
  bool was_ever_connected_ ABSL_GUARDED_BY(mutex_) = false;
  bool opening_ ABSL_GUARDED_BY(mutex_) = false;
  // True if an attempt failed or was slow that nobody has looked into yet.
  bool trouble_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time without_since_ ABSL_GUARDED_BY(mutex_);
  absl::Time opened_at_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  // Sessions in a row that did not last, and whether the last line said that none stands.
  uint64_t short_lived_ ABSL_GUARDED_BY(mutex_) = 0;
  bool warned_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status seen_ ABSL_GUARDED_BY(mutex_);
  // The cause that was found out last, for which `seen_`, and when.
  absl::Status cause_ ABSL_GUARDED_BY(mutex_);
  absl::Status explained_ ABSL_GUARDED_BY(mutex_);
  absl::Time explained_at_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  // What was written last, and when.
  absl::Status said_ ABSL_GUARDED_BY(mutex_);
  absl::Time said_at_ ABSL_GUARDED_BY(mutex_);
  RareReminder reminder_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_UPLINK_LOG_H_
