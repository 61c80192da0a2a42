#include "services/observe/event_log/uplink_log.h"

#include <glog/logging.h>

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/exchange/session_end.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

// Returns what the robot does about a session that can't be had, or ended so.
const char* WhetherItAsksAgain(const absl::Status& cause) {
  if (SaysMissionDeleted(cause)) return ", and does not try again";
  const bool is_refused =
      absl::IsAborted(cause) || absl::IsPermissionDenied(cause) || absl::IsInvalidArgument(cause);
  return is_refused ? ", and asks again every two minutes at least" : ", and tries again";
}

std::string WhatMappingDoes(const absl::Status& cause) {
  return absl::StrCat("; the robot maps on",
                      SaysMissionDeleted(cause) ? "" : ", keeps what the store lacks",
                      WhetherItAsksAgain(cause));
}

std::string WhatLocalisingDoes(const absl::Status& cause, bool has_a_map) {
  std::string text = has_a_map ? "; the robot localises on in what it was told of the map"
                               : "; the robot only localises, and has no map until a session "
                                 "stands: it is lost";
  absl::StrAppend(&text, WhetherItAsksAgain(cause));
  if (!absl::IsNotFound(cause)) return text;
  return absl::StrCat(text,
                      ". Is --mission right? corbslam mission list says which missions there are, "
                      "and a robot without --localise-only begins one");
}

// So many sessions in a row that do not last are told as one trouble.
constexpr uint64_t kFlapping = 3;

std::string TextOf(absl::Duration duration) {
  if (duration < absl::Seconds(1)) return "less than a second";
  return absl::FormatDuration(absl::Trunc(duration, absl::Seconds(1)));
}

}  // namespace

UplinkLog::UplinkLog(LogFields who, Explain explain, const UplinkLogOptions& options)
    : who_(std::move(who)),
      explain_(std::move(explain)),
      options_(options),
      without_since_(options_.clock()),
      thread_(StartThread("uplink log", [this] { Run(); })) {}

UplinkLog::~UplinkLog() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  thread_.join();
}

absl::Status UplinkLog::status() const {
  absl::MutexLock lock(&mutex_);
  if (connected_) return absl::OkStatus();
  if (!cause_.ok()) return cause_;
  return seen_.ok() ? absl::UnavailableError("no session stands yet") : seen_;
}

void UplinkLog::OnOpening() {
  absl::MutexLock lock(&mutex_);
  opening_ = true;
}

void UplinkLog::OnOpened() {
  absl::MutexLock lock(&mutex_);
  connected_ = was_ever_connected_ = true;
  opening_ = trouble_ = false;
  opened_at_ = options_.clock();
  if (std::exchange(warned_, false)) {
    LOG(WARNING) << who_ << "a session with the map store stands again, after "
                 << TextOf(opened_at_ - without_since_) << " without";
  } else if (short_lived_ == 0) {
    LOG(INFO) << who_ << "a session with the map store stands";
  }
  seen_ = cause_ = absl::OkStatus();
  explained_at_ = absl::InfinitePast();
}

void UplinkLog::NoteLength(absl::Duration stood) {
  if (stood < options_.lasting) {
    ++short_lived_;
    return;
  }
  short_lived_ = 0;
  said_ = absl::OkStatus();
  reminder_.Reset();
}

void UplinkLog::OnClosed(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  if (connected_) {
    without_since_ = options_.clock();
    NoteLength(without_since_ - opened_at_);
  }
  connected_ = opening_ = false;
  seen_ = reason;
  trouble_ = true;
}

void UplinkLog::Run() {
  while (const std::optional<absl::Status> seen = WaitForTrouble()) {
    NoteCause(*seen, explain_(*seen));
  }
}

std::optional<absl::Status> UplinkLog::WaitForTrouble() {
  absl::MutexLock lock(&mutex_);
  const auto is_any = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return trouble_ || stop_; };
  const auto may_come = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return trouble_ || stop_ || opening_;
  };
  while (true) {
    mutex_.Await(absl::Condition(&may_come));
    const bool happened = mutex_.AwaitWithTimeout(absl::Condition(&is_any), options_.slow_attempt);
    if (stop_) return std::nullopt;
    // A slow attempt is trouble, too, though it may yet succeed.
    if (!happened && !opening_) continue;
    trouble_ = false;
    if (NeedsExplanation()) return seen_;
    WarnIfDue();
  }
}

std::string UplinkLog::DescribeShortLived() const {
  if (short_lived_ < 2) return "";
  return absl::StrCat("; ", short_lived_, " sessions in a row ended within ",
                      TextOf(options_.lasting));
}

bool UplinkLog::NeedsExplanation() const {
  return explained_ != seen_ || options_.clock() - explained_at_ >= options_.explain_again;
}

void UplinkLog::NoteCause(const absl::Status& seen, const absl::Status& cause) {
  absl::MutexLock lock(&mutex_);
  explained_ = seen;
  explained_at_ = options_.clock();
  cause_ = cause.ok() ? seen : cause;
  WarnIfDue();
}

void UplinkLog::WarnIfDue() {
  if (connected_ || cause_.ok()) return;
  const absl::Time now = options_.clock();
  // A session that stood meanwhile, and not again and again, makes another cause news at once.
  const bool stood = !warned_ && short_lived_ < kFlapping;
  const bool is_new = cause_ != said_ && (stood || now - said_at_ >= options_.explain_again);
  if (!reminder_.IsDue(now) && !is_new) return;
  said_ = cause_;
  said_at_ = now;
  warned_ = true;
  const absl::Duration without = now - without_since_;
  LOG(WARNING) << who_ << "no session with the map store "
               << (without >= absl::Seconds(1)          ? absl::StrCat("since ", TextOf(without))
                   : opened_at_ == absl::InfinitePast() ? "yet"
                                                        : "any more")
               << ": " << cause_ << DescribeShortLived()
               << (options_.localise_only ? WhatLocalisingDoes(cause_, was_ever_connected_)
                                          : WhatMappingDoes(cause_));
}

}  // namespace corbslam::services
