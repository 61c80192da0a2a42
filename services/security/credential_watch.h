// Reads certificates, keys and lists again while a program runs.
#ifndef CORBSLAM_SERVICES_SECURITY_CREDENTIAL_WATCH_H_
#define CORBSLAM_SERVICES_SECURITY_CREDENTIAL_WATCH_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::services {

// What a file holds that programs take their credentials from.
enum class Credential { kCertificate, kAuthorities, kTokenKeys, kRevokedTokens, kWebCertificate };
inline constexpr Credential kCredentials[] = {Credential::kCertificate, Credential::kAuthorities,
                                              Credential::kTokenKeys, Credential::kRevokedTokens,
                                              Credential::kWebCertificate};
// Returns "certificate", "authorities", "token_keys", "revoked_tokens" or "web_certificate" (the
// one that browsers are shown).
std::string ToString(Credential credential);

// How a credential of this process is.
struct CredentialState {
  Credential credential = Credential::kCertificate;
  // When the first certificate in it expires; InfiniteFuture: never, or it holds none.
  absl::Time expires = absl::InfiniteFuture();
  // How often a new content was taken after the first.
  uint64_t taken = 0;
  // The file's content can't be used, so that an older one is.
  bool refused = false;
};
// Returns one state for each credential, over all watches of this process that are alive: what is
// not watched never expires.
std::vector<CredentialState> CredentialStates();

// Looks after a few files on a thread of its own. What it reads is checked before it is taken; what
// can't be taken is said in the log (at once, then rarely), and what was taken before stays.
// Thread-safe.
class CredentialWatch {
 public:
  struct Source {
    Credential credential = Credential::kCertificate;
    // Returns the content, checked; an error says what is wrong with which file.
    std::function<absl::StatusOr<std::string>()> read;
    // Puts a new content into force.
    std::function<absl::Status(const std::string&)> take;
  };

  // So often files are read. A content that is wrong is refused when it is read a second time: key
  // and certificate are written one after the other.
  static constexpr absl::Duration kInterval = absl::Seconds(2);

  explicit CredentialWatch(absl::Duration interval = kInterval) : interval_(interval) {}
  ~CredentialWatch();
  CredentialWatch(const CredentialWatch&) = delete;
  CredentialWatch& operator=(const CredentialWatch&) = delete;

  // Reads and takes a source for the first time; an error is the caller's to deal with. Not after
  // Start.
  absl::Status Add(Source source);
  // Does the same, but one that is bad is said in the log and watched all the same: nothing is in
  // force until it is good.
  void AddOrWait(Source source);
  // Begins to poll. Called once.
  void Start();
  // Reads all sources now.
  void Poll() ABSL_LOCKS_EXCLUDED(mutex_);

  std::vector<CredentialState> states() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Watched {
    Source source;
    std::string content;
    CredentialState state;
    // What was wrong when it was last read; empty: nothing.
    std::string wrong;
    RareReminder reminder;
  };

  void Run();
  void LookAt(Watched& watched) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static absl::Status TakeNew(Watched& watched);
  static void Refuse(const absl::Status& why, Watched& watched);

  const absl::Duration interval_;
  absl::Notification stop_;
  mutable absl::Mutex mutex_;
  std::vector<Watched> watched_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_CREDENTIAL_WATCH_H_
