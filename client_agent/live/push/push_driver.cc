#include "client_agent/live/push/push_driver.h"

#include <glog/logging.h>

#include <opencv2/core/mat.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/push_client/corbslam/push.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::Duration kHelloWithin = absl::Seconds(2);
constexpr size_t kMostPoses = 64;
constexpr size_t kMostPacketBytes = sizeof(push_wire::Hello) + push_wire::kMostRigBytes;

}  // namespace

PushDriver::PushDriver(UniqueFd socket, PushHost& host)
    : socket_(std::move(socket)),
      host_(host),
      who_(PeerOf(fd())),
      hello_until_(absl::Now() + kHelloWithin) {}

absl::Status PushDriver::Read() {
  ASSIGN_OR_RETURN(std::optional<Packet> packet, ReceivePacket(fd(), kMostPacketBytes));
  if (!packet.has_value()) return absl::OkStatus();
  const absl::Status taken = Take(*std::move(packet));
  if (!taken.ok()) return Refuse(taken);
  Write();
  return absl::OkStatus();
}

absl::Status PushDriver::Take(Packet packet) {
  if (packet.is_cut) {
    return absl::InvalidArgumentError(
        absl::StrCat("bytes: a message has at most ", kMostPacketBytes, ", and carries one file"));
  }
  if (!is_welcome()) return TakeHello(packet);
  return IsImu(packet.bytes) ? TakeImu(packet) : TakeFrame(packet);
}

absl::Status PushDriver::TakeHello(const Packet& packet) {
  ASSIGN_OR_RETURN(const PushHello hello, ParseHello(packet.bytes));
  if (packet.files.size() != 1) {
    return absl::InvalidArgumentError(absl::StrCat("memory: the hello carries ",
                                                   packet.files.size(),
                                                   " files, must be the one of the memory"));
  }
  ASSIGN_OR_RETURN(SharedRing ring, SharedRing::Map(packet.files.front(), hello.layout));
  if (!hello.name.empty()) who_ = absl::StrCat("'", hello.name, "' (", who_, ")");
  RETURN_IF_ERROR(host_.OnHello(hello));
  layout_ = hello.layout;
  ring_ = std::move(ring);
  LOG(INFO) << "the driver " << who_ << " is connected";
  // Nothing was sent before: the socket has room for it. Whether the driver went is read later.
  SendPacket(fd(), FormatWelcome(host_.takes_imu())).status().IgnoreError();
  return absl::OkStatus();
}

absl::Status PushDriver::TakeFrame(const Packet& packet) {
  ASSIGN_OR_RETURN(const PushFrame frame, ParseFrame(packet.bytes, layout_));
  if (!packet.files.empty()) {
    return absl::InvalidArgumentError("memory: a frame carries no file, only the hello does");
  }
  const uint64_t bit = uint64_t{1} << frame.slot;
  if ((free_slots_ & bit) != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("slot is ", frame.slot, ", which was not given back yet"));
  }
  const cv::Mat first = grey_scaler_.ToEightBits(ring_->CopyFirst(frame.slot));
  cv::Mat second;
  if (layout_.second.format != 0) second = ring_->CopySecond(frame.slot);
  if (layout_.second.format == CORBSLAM_PUSH_GREY16) second = grey_scaler_.ToEightBits(second);
  RETURN_IF_ERROR(host_.OnFrame(frame.timestamp_ns, first, second));
  free_slots_ |= bit;
  return absl::OkStatus();
}

absl::Status PushDriver::TakeImu(const Packet& packet) {
  ASSIGN_OR_RETURN(const ImuSamples samples, ParseImu(packet.bytes));
  if (!packet.files.empty()) {
    return absl::InvalidArgumentError("memory: samples carry no file, only the hello does");
  }
  return host_.OnImu(samples);
}

absl::Status PushDriver::Refuse(absl::Status why) {
  // One that takes nothing at the moment is not told.
  if (!absl::IsUnavailable(why))
    SendPacket(fd(), FormatRefusal(why.message())).status().IgnoreError();
  return why;
}

absl::Status PushDriver::CheckHello(absl::Time now) {
  if (is_welcome() || now < hello_until_) return absl::OkStatus();
  return Refuse(absl::DeadlineExceededError(
      absl::StrCat("no hello came within ", absl::FormatDuration(kHelloWithin))));
}

void PushDriver::Write() {
  // To one that went everything is sent: what it had said before is still to be read.
  const auto is_sent = [this](const std::string& message) {
    return SendPacket(fd(), message).value_or(true);
  };
  if (free_slots_ != 0) {
    if (!is_sent(FormatSlotsFree(free_slots_))) return;
    free_slots_ = 0;
  }
  while (!poses_.empty() && is_sent(poses_.front())) poses_.pop_front();
}

void PushDriver::AddPose(std::string message) {
  if (poses_.size() >= kMostPoses) poses_.pop_front();
  poses_.push_back(std::move(message));
}

void TurnAway(UniqueFd socket, absl::string_view why) {
  SendPacket(socket.get(), FormatRefusal(why)).status().IgnoreError();
}

}  // namespace corbslam::client_agent
