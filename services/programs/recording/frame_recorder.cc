#include "services/programs/recording/frame_recorder.h"

#include <glog/logging.h>

#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/programs/recording/recorded_agent.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentOrders;
using client_agent::OrdersForFrame;
using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

constexpr absl::Duration kTellAgain = absl::Seconds(10);

uint64_t BytesOf(const SensorImages& images) {
  uint64_t bytes = 0;
  for (const cv::Mat* picture : {&images.grey, &images.right, &images.depth}) {
    bytes += picture->total() * picture->elemSize();
  }
  return bytes;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameRecorder>> FrameRecorder::Start(
    const std::string& folder, RecordingHead head, const RecorderOptions& options) {
  head.has_mask = std::visit([](const auto& kind) { return !kind.mask.empty(); }, head.calibration);
  ASSIGN_OR_RETURN(std::unique_ptr<RecordingFiles> files,
                   RecordingFiles::Create(folder, head, options.rate_hz));
  LOG(INFO) << "recording what is tracked to " << folder;
  return std::unique_ptr<FrameRecorder>(
      new FrameRecorder(std::move(head), std::move(files), options));
}

FrameRecorder::FrameRecorder(RecordingHead head, std::unique_ptr<RecordingFiles> files,
                             const RecorderOptions& options)
    : options_(options),
      has_imu_(std::visit([](const auto& kind) { return kind.imu.has_value(); }, head.calibration)),
      files_(std::move(files)),
      head_(std::move(head)),
      thread_(StartThread("recorder", [this] { Run(); })) {}

FrameRecorder::~FrameRecorder() { Finish().IgnoreError(); }

std::unique_ptr<Agent> FrameRecorder::Watch(Agent* agent, AgentOrders* orders) {
  if (orders != nullptr) {
    orders->SetListener([this](const OrdersForFrame& taken) { OnOrders(taken); });
  }
  return MakeRecordedAgent(agent, this);
}

void FrameRecorder::OnNewLocalMap() { begins_local_map_ = true; }

void FrameRecorder::OnFrame(const SensorImages& images) {
  absl::MutexLock lock(&mutex_);
  if (options_.waits) mutex_.Await(absl::Condition(this, &FrameRecorder::HasRoom));
  FrameLine line;
  line.frame = frame_ = head_.counts.frames++;
  line.timestamp_ns = images.timestamp_ns;
  line.begins_local_map = std::exchange(begins_local_map_, false);
  if (!failure_.ok()) {
    ++head_.counts.left_out;
    return;
  }
  if (has_imu_) line.imu_samples = images.imu.size();
  Item item{line, std::nullopt, 0};
  if (has_imu_) item.imu = images.imu;
  if (HasRoom()) {
    item.images = images;
    item.images->imu.clear();
    item.bytes = BytesOf(images);
    waiting_bytes_ += item.bytes;
  } else {
    ++head_.counts.left_out;
    TellLeftOut(absl::Now());
  }
  Push(std::move(item));
}

// Lines can't be left out: what is behind one that is missing can't be played.
void FrameRecorder::Push(Item item) {
  if (options_.waits || queue_.size() < options_.max_waiting_lines) {
    queue_.push_back(std::move(item));
    return;
  }
  if (item.images.has_value()) ++head_.counts.left_out;
  EndBecause(
      absl::UnavailableError(absl::StrCat("its disk has taken nothing for ", queue_.size(),
                                          " lines: it hangs, or is far slower than the camera")));
}

void FrameRecorder::OnOrders(const OrdersForFrame& orders) {
  absl::MutexLock lock(&mutex_);
  if (!failure_.ok()) return;
  OrdersLine line{frame_, orders.mapping_paused, orders.open_local_map};
  if (orders.mask.has_value()) line.has_mask = !orders.mask->empty();
  Item item{line, std::nullopt, 0};
  if (line.has_mask.value_or(false)) {
    item.mask = *orders.mask;
    item.bytes = item.mask.total();
    if (!HasRoom() && !options_.waits) {
      return EndBecause(absl::ResourceExhaustedError(
          "there is no memory for a mask that was ordered while its disk is slow (--record-mb)"));
    }
    waiting_bytes_ += item.bytes;
  }
  Push(std::move(item));
}

void FrameRecorder::TellLeftOut(absl::Time now) {
  if (now - told_left_out_ < kTellAgain) return;
  told_left_out_ = now;
  LOG(WARNING) << "the recording's disk is slower than the camera: " << head_.counts.left_out
               << " of " << head_.counts.frames
               << " frames are left out of it so far, the robot tracked them; take a faster disk, "
                  "or more memory (--record-mb)";
}

void FrameRecorder::OnResult(const TrackingResult& result, uint64_t dropped) {
  absl::MutexLock lock(&mutex_);
  head_.counts.dropped = dropped;
  if (result.state == TrackingState::kTracking) ++head_.counts.tracked;
  if (!failure_.ok()) return;
  Push({ResultLine{frame_, dropped, result}, std::nullopt, 0});
}

void FrameRecorder::Run() {
  while (true) {
    Item item;
    {
      absl::MutexLock lock(&mutex_);
      mutex_.Await(absl::Condition(this, &FrameRecorder::HasSomething));
      if (queue_.empty()) return;
      item = std::move(queue_.front());
      queue_.pop_front();
    }
    if (const absl::Status written = Write(item); !written.ok()) return Fail(item, written);
    absl::MutexLock lock(&mutex_);
    if (failure_.ok()) waiting_bytes_ -= item.bytes;
  }
}

absl::Status FrameRecorder::Write(const Item& item) {
  if (const auto* const orders = std::get_if<OrdersLine>(&item.line)) {
    return files_->WriteOrders(*orders, item.mask);
  }
  RETURN_IF_ERROR(files_->WriteImu(item.imu));
  if (!item.images.has_value()) return files_->WriteLine(item.line);
  return files_->WriteFrame(*item.images, options_.least_free_bytes,
                            std::get<FrameLine>(item.line));
}

void FrameRecorder::Fail(const Item& failed, const absl::Status& why) {
  absl::MutexLock lock(&mutex_);
  if (!failure_.ok()) return;
  queue_.push_back(failed);
  EndBecause(why);
}

void FrameRecorder::EndBecause(const absl::Status& why) {
  LOG(ERROR) << "the recording ends, the robot goes on: " << why.message();
  failure_ = why;
  head_.ended = std::string(why.message());
  for (const Item& item : queue_) head_.counts.left_out += item.images.has_value() ? 1 : 0;
  queue_.clear();
  waiting_bytes_ = 0;
}

absl::Status FrameRecorder::Finish() {
  {
    absl::MutexLock lock(&mutex_);
    ending_ = true;
  }
  if (!thread_.joinable()) return absl::OkStatus();
  thread_.join();
  absl::MutexLock lock(&mutex_);
  head_.finished = true;
  const absl::Status written = files_->WriteHead(head_);
  if (!written.ok()) LOG(ERROR) << "the recording has no end: " << written.message();
  LOG(INFO) << "recorded " << head_.counts.frames - head_.counts.left_out << " of "
            << head_.counts.frames << " frames that were tracked";
  return failure_.ok() ? written : failure_;
}

}  // namespace corbslam::services
