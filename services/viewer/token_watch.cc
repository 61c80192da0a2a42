#include "services/viewer/token_watch.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "services/security/revoked_list.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kPatience = absl::Seconds(2);
// A token that nobody has shown for so long is asked about no more.
constexpr absl::Duration kMemory = absl::Minutes(1);
// More are taken by what the viewer itself knows.
constexpr size_t kMaxTokens = 1000;

}  // namespace

TokenWatch::TokenWatch(const std::shared_ptr<grpc::Channel>& store, absl::Duration interval)
    : store_(store != nullptr ? v1::MapStore::NewStub(store) : nullptr), interval_(interval) {
  if (store_ != nullptr) thread_ = StartThread("token watch", [this] { Run(); });
}

TokenWatch::~TokenWatch() {
  stop_.Notify();
  if (thread_.joinable()) thread_.join();
}

absl::Status TokenWatch::Check(const std::string& id, const std::string& token,
                               const std::string& mission) {
  if (store_ == nullptr || id.empty()) return absl::OkStatus();
  absl::MutexLock lock(&mutex_);
  const auto found = tokens_.find(id);
  if (found == tokens_.end()) {
    if (tokens_.size() < kMaxTokens) tokens_[id] = {token, mission, absl::Now(), false, {}};
    return absl::OkStatus();
  }
  found->second.last_shown = absl::Now();
  return found->second.revoked;
}

absl::Status TokenWatch::AskAndCheck(const std::string& id, const std::string& token,
                                     const std::string& mission) {
  if (store_ == nullptr || id.empty()) return absl::OkStatus();
  Check(id, token, mission).IgnoreError();
  bool is_answered = false;
  {
    absl::MutexLock lock(&mutex_);
    const auto found = tokens_.find(id);
    is_answered = found == tokens_.end() || found->second.is_answered;
  }
  if (!is_answered) Ask(id, token, mission);
  return Check(id, token, mission);
}

void TokenWatch::Run() {
  while (!stop_.WaitForNotificationWithTimeout(interval_)) {
    std::vector<std::pair<std::string, Token>> asked;
    {
      absl::MutexLock lock(&mutex_);
      const absl::Time old = absl::Now() - kMemory;
      std::erase_if(tokens_, [old](const auto& entry) { return entry.second.last_shown < old; });
      asked.assign(tokens_.begin(), tokens_.end());
    }
    for (const auto& [id, token] : asked) {
      if (stop_.HasBeenNotified()) return;
      Ask(id, token.text, token.mission);
    }
  }
}

void TokenWatch::Ask(const std::string& id, const std::string& token, const std::string& mission) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + kPatience));
  context.AddMetadata("authorization", absl::StrCat("Bearer ", token));
  v1::GetMissionRequest request;
  request.set_name(MissionName(mission));
  v1::Mission response;
  const absl::Status status =
      ToStatus(store_->GetMission(&context, request, &response), "GetMission");
  // The store did not say anything.
  if (absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status)) return;
  absl::MutexLock lock(&mutex_);
  const auto found = tokens_.find(id);
  if (found == tokens_.end()) return;
  found->second.is_answered = true;
  found->second.revoked = SaysRevoked(status) ? status : absl::OkStatus();
}

}  // namespace corbslam::services
