#include "services/map_store_service/streams/stream_limits.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

template <typename Value, typename Limit>
absl::Status CheckRange(absl::string_view field, Value value, Limit low, Limit high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", value, ", must be in [", low, ", ", high, "]"));
}

absl::Status TooMany(absl::string_view whose, size_t has, size_t limit) {
  return absl::ResourceExhaustedError(
      absl::StrCat(whose, " has ", has, " open streams; the limit is ", limit));
}

absl::Status Stopping() { return absl::UnavailableError("the map store is stopping"); }

}  // namespace

absl::Status StreamLimitOptions::Validate() const {
  constexpr size_t kMany = size_t{1} << 40;
  absl::Status status;
  status.Update(CheckRange("max_streams", max_streams, size_t{1}, kMany));
  status.Update(CheckRange("max_streams_per_host", max_streams_per_host, size_t{1}, kMany));
  status.Update(CheckRange("max_streams_per_agent", max_streams_per_agent, size_t{2}, kMany));
  // Above this range gRPC itself refuses messages; below it our own parts don't fit.
  status.Update(
      CheckRange("max_message_bytes", max_message_bytes, kPartBytes + (1u << 20), size_t{4} << 20));
  status.Update(CheckRange("max_batch_bytes", max_batch_bytes, size_t{1} << 20, kMaxUpdateBytes));
  status.Update(CheckRange("max_unfinished_bytes", max_unfinished_bytes, max_batch_bytes, kMany));
  status.Update(CheckRange("open_timeout_s", open_timeout_s, 0.1, 1e5));
  status.Update(CheckRange("part_timeout_s", part_timeout_s, 0.1, 1e5));
  status.Update(CheckRange("max_waiting_calls", max_waiting_calls, size_t{1}, kMany));
  return status;
}

std::string HostOfPeer(absl::string_view peer) {
  const bool has_port = absl::StartsWith(peer, "ipv4:") || absl::StartsWith(peer, "ipv6:");
  return std::string(has_port ? peer.substr(0, peer.rfind(':')) : peer);
}

absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> StreamLimits::Enter(absl::string_view peer,
                                                                          StayCheck may_stay) {
  std::string host = HostOfPeer(peer);
  absl::MutexLock lock(&mutex_);
  if (closed_) return Stopping();
  if (tickets_.size() >= options_.max_streams) {
    return TooMany("this server", tickets_.size(), options_.max_streams);
  }
  size_t& of_host = of_host_[host];
  if (of_host >= options_.max_streams_per_host) {
    return TooMany(host, of_host, options_.max_streams_per_host);
  }
  ++of_host;
  auto ticket = std::make_unique<Ticket>(this, std::move(host), std::move(may_stay));
  tickets_.insert(ticket.get());
  return ticket;
}

void StreamLimits::Close() {
  absl::MutexLock lock(&mutex_);
  closed_ = true;
  for (Ticket* ticket : tickets_) {
    if (ticket->on_close_ != nullptr) ticket->on_close_(Stopping());
  }
}

void StreamLimits::EndWhoMayNotStay() {
  absl::MutexLock lock(&mutex_);
  for (Ticket* ticket : tickets_) {
    if (ticket->on_close_ == nullptr || ticket->may_stay_ == nullptr) continue;
    const absl::Status may_stay = ticket->may_stay_();
    if (!may_stay.ok()) ticket->on_close_(may_stay);
  }
}

void StreamLimits::Decrease(const std::string& key, Counts& counts) {
  const auto it = counts.find(key);
  if (--it->second == 0) counts.erase(it);
}

size_t StreamLimits::open_streams() const {
  absl::MutexLock lock(&mutex_);
  return tickets_.size();
}

size_t StreamLimits::unfinished_bytes() const {
  absl::MutexLock lock(&mutex_);
  return unfinished_bytes_;
}

StreamLimits::Ticket::~Ticket() {
  ReleaseAll();
  absl::MutexLock lock(&limits_.mutex_);
  limits_.tickets_.erase(this);
  Decrease(host_, limits_.of_host_);
  if (!agent_.empty()) Decrease(agent_, limits_.of_agent_);
}

absl::Status StreamLimits::Ticket::SetCloseListener(
    std::function<void(const absl::Status&)> listener) {
  absl::MutexLock lock(&limits_.mutex_);
  if (limits_.closed_) return Stopping();
  // What forbids it may have come between the call's check and now.
  if (may_stay_ != nullptr) RETURN_IF_ERROR(may_stay_());
  on_close_ = std::move(listener);
  return absl::OkStatus();
}

absl::Status StreamLimits::Ticket::Name(const std::string& agent) {
  absl::MutexLock lock(&limits_.mutex_);
  if (agent_ == agent) return absl::OkStatus();
  const size_t limit = limits_.options_.max_streams_per_agent;
  size_t& of_agent = limits_.of_agent_[agent];
  if (of_agent >= limit) return TooMany(agent, of_agent, limit);
  ++of_agent;
  agent_ = agent;
  return absl::OkStatus();
}

absl::Status StreamLimits::Ticket::Hold(size_t bytes) {
  const StreamLimitOptions& options = limits_.options_;
  if (held_ + bytes > options.max_batch_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat("an unfinished batch has ", held_ + bytes,
                                                     " bytes; the limit is ",
                                                     options.max_batch_bytes));
  }
  absl::MutexLock lock(&limits_.mutex_);
  if (limits_.unfinished_bytes_ + bytes > options.max_unfinished_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "unfinished batches of all streams have ", limits_.unfinished_bytes_, " bytes; with ",
        bytes, " more they pass the limit of ", options.max_unfinished_bytes));
  }
  held_ += bytes;
  limits_.unfinished_bytes_ += bytes;
  return absl::OkStatus();
}

void StreamLimits::Ticket::Release(size_t bytes) {
  absl::MutexLock lock(&limits_.mutex_);
  limits_.unfinished_bytes_ -= bytes;
  held_ -= bytes;
}

void StreamLimits::Ticket::ReleaseAll() { Release(held_); }

}  // namespace corbslam::services
