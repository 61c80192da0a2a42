#include "client_agent/agent/place_inquiry.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "slam/util/named_thread.h"

namespace corbslam::client_agent {
namespace {

// What a keypoint takes on the wire, with its descriptor, about.
constexpr double kBytesPerKeypoint = 48;
// Share of the link that questions may take.
constexpr double kShareOfLink = 0.25;

// Whether it is worth while to ask again later. A mission may not be there yet: it begins with its
// first robot's session.
bool Passes(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) ||
         absl::IsResourceExhausted(status) || absl::IsNotFound(status);
}

absl::Duration TimeOnLink(const KeyframePayload& frame, uint64_t bytes_per_second) {
  if (bytes_per_second == 0) return absl::ZeroDuration();
  const double bytes = kBytesPerKeypoint * static_cast<double>(frame.features.keypoints.size());
  return absl::Seconds(bytes / (kShareOfLink * static_cast<double>(bytes_per_second)));
}

}  // namespace

PlaceInquiry::PlaceInquiry(AskPlace ask, const PlaceInquiryOptions& options, bool threaded)
    : ask_(std::move(ask)), options_(options), interval_(options.interval) {
  if (ask_ != nullptr && threaded) thread_ = StartThread("place inquiry", [this] { Run(); });
}

PlaceInquiry::~PlaceInquiry() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

bool PlaceInquiry::MayAsk(bool is_lost) const {
  if (ask_ == nullptr) return false;
  absl::MutexLock lock(&mutex_);
  if (busy_ || given_up_ || answer_.has_value()) return false;
  return options_.clock() >= (is_lost ? next_when_lost_ : next_);
}

void PlaceInquiry::Ask(PlaceQuestion question) {
  if (!MayAsk(!question.camera_from_local.has_value())) return;
  if (!thread_.joinable()) return Answer(question);
  absl::MutexLock lock(&mutex_);
  busy_ = true;
  question_ = std::move(question);
}

void PlaceInquiry::BeginLocalMap() {
  absl::MutexLock lock(&mutex_);
  interval_ = options_.interval;
  next_ = std::min(next_, next_when_lost_);
}

std::optional<PlaceAnswer> PlaceInquiry::TakeAnswer() {
  absl::MutexLock lock(&mutex_);
  return std::exchange(answer_, std::nullopt);
}

void PlaceInquiry::Run() {
  while (true) {
    PlaceQuestion question;
    {
      absl::MutexLock lock(&mutex_);
      const auto has_work = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return stop_ || question_.has_value();
      };
      mutex_.Await(absl::Condition(&has_work));
      if (stop_) return;
      question = *std::exchange(question_, std::nullopt);
    }
    Answer(question);
  }
}

void PlaceInquiry::Answer(const PlaceQuestion& question) {
  Conclude(question, ask_(*question.frame));
}

void PlaceInquiry::Conclude(const PlaceQuestion& question,
                            const absl::StatusOr<std::optional<Rigid3d>>& found) {
  absl::MutexLock lock(&mutex_);
  busy_ = false;
  const absl::Time now = options_.clock();
  const absl::Duration on_link = TimeOnLink(*question.frame, options_.uplink_bytes_per_second);
  next_when_lost_ = now + std::max(options_.interval, on_link);
  next_ = now + std::max(interval_, on_link);
  if (question.camera_from_local.has_value()) {
    interval_ = std::min(2 * interval_, options_.longest_interval);
  }
  if (!found.ok()) {
    given_up_ = !Passes(found.status());
    next_when_lost_ = next_ = now + std::max(options_.patience, on_link);
    LOG_IF(WARNING, given_up_) << "the map store does not look up where frames were, and is not "
                                  "asked any more: "
                               << found.status();
    return;
  }
  if (!found->has_value()) return;
  answer_ = PlaceAnswer{question, **found};
}

}  // namespace corbslam::client_agent
