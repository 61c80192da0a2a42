#include "services/security/credential_watch.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "absl/time/clock.h"
#include "services/security/pem_files.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Knows the watches of this process that are alive.
struct LiveWatches {
  absl::Mutex mutex;
  std::set<const CredentialWatch*> watches ABSL_GUARDED_BY(mutex);
};
LiveWatches& Live() {
  static auto& live = *new LiveWatches();
  return live;
}

absl::Time ExpiryOf(Credential credential, const std::string& content) {
  const bool has_certificates = credential == Credential::kCertificate ||
                                credential == Credential::kAuthorities ||
                                credential == Credential::kWebCertificate;
  return has_certificates ? FirstExpiry(content) : absl::InfiniteFuture();
}

}  // namespace

std::string ToString(Credential credential) {
  switch (credential) {
    case Credential::kCertificate:
      return "certificate";
    case Credential::kAuthorities:
      return "authorities";
    case Credential::kTokenKeys:
      return "token_keys";
    case Credential::kRevokedTokens:
      return "revoked_tokens";
    case Credential::kWebCertificate:
      return "web_certificate";
  }
  return "";
}

std::vector<CredentialState> CredentialStates() {
  std::vector<CredentialState> all;
  for (const Credential credential : kCredentials) all.push_back({.credential = credential});
  absl::MutexLock lock(&Live().mutex);
  for (const CredentialWatch* watch : Live().watches) {
    for (const CredentialState& state : watch->states()) {
      CredentialState& sum =
          *std::ranges::find(all, state.credential, &CredentialState::credential);
      sum.expires = std::min(sum.expires, state.expires);
      sum.taken = std::max(sum.taken, state.taken);
      sum.refused = sum.refused || state.refused;
    }
  }
  return all;
}

CredentialWatch::~CredentialWatch() {
  {
    absl::MutexLock lock(&Live().mutex);
    Live().watches.erase(this);
  }
  if (!thread_.joinable()) return;
  stop_.Notify();
  thread_.join();
}

absl::Status CredentialWatch::Add(Source source) {
  Watched watched;
  ASSIGN_OR_RETURN(watched.content, source.read());
  RETURN_IF_ERROR(source.take(watched.content));
  watched.state.credential = source.credential;
  watched.state.expires = ExpiryOf(source.credential, watched.content);
  watched.source = std::move(source);
  absl::MutexLock lock(&mutex_);
  watched_.push_back(std::move(watched));
  return absl::OkStatus();
}

void CredentialWatch::AddOrWait(Source source) {
  const absl::Status added = Add(source);
  if (added.ok()) return;
  Watched watched;
  watched.state.credential = source.credential;
  watched.source = std::move(source);
  // It may stay so for long: whoever reads the log knows at once.
  watched.wrong = std::string(added.message());
  Refuse(added, watched);
  absl::MutexLock lock(&mutex_);
  watched_.push_back(std::move(watched));
}

void CredentialWatch::Start() {
  {
    absl::MutexLock lock(&Live().mutex);
    Live().watches.insert(this);
  }
  thread_ = StartThread("credentials", [this] { Run(); });
}

void CredentialWatch::Run() {
  while (!stop_.WaitForNotificationWithTimeout(interval_)) Poll();
}

void CredentialWatch::Poll() {
  absl::MutexLock lock(&mutex_);
  for (Watched& watched : watched_) LookAt(watched);
}

void CredentialWatch::LookAt(Watched& watched) {
  const absl::Status status = TakeNew(watched);
  if (!status.ok()) return Refuse(status, watched);
  if (watched.state.refused) {
    LOG(INFO) << "credentials, " << ToString(watched.state.credential) << ": good again";
  }
  watched.state.refused = false;
  watched.wrong.clear();
  watched.reminder.Reset();
}

absl::Status CredentialWatch::TakeNew(Watched& watched) {
  ASSIGN_OR_RETURN(std::string content, watched.source.read());
  if (content == watched.content) return absl::OkStatus();
  RETURN_IF_ERROR(watched.source.take(content));
  watched.content = std::move(content);
  CredentialState& state = watched.state;
  state.expires = ExpiryOf(state.credential, watched.content);
  ++state.taken;
  LOG(INFO) << "credentials, " << ToString(state.credential) << ": new content is in force"
            << (state.expires < absl::InfiniteFuture()
                    ? " until " + absl::FormatTime(state.expires, absl::UTCTimeZone())
                    : "");
  return absl::OkStatus();
}

void CredentialWatch::Refuse(const absl::Status& why, Watched& watched) {
  // The other file of a pair may come a moment later.
  if (watched.wrong.empty()) {
    watched.wrong = std::string(why.message());
    return;
  }
  if (watched.wrong != why.message()) watched.reminder.Reset();
  watched.wrong = std::string(why.message());
  watched.state.refused = true;
  if (!watched.reminder.IsDue(absl::Now())) return;
  LOG(ERROR) << "credentials, " << ToString(watched.state.credential) << ": " << watched.wrong
             << (watched.content.empty() ? "; nothing is in force until it is good"
                                         : "; what was read before stays in force");
}

std::vector<CredentialState> CredentialWatch::states() const {
  absl::MutexLock lock(&mutex_);
  std::vector<CredentialState> states;
  std::ranges::transform(watched_, std::back_inserter(states), &Watched::state);
  return states;
}

}  // namespace corbslam::services
