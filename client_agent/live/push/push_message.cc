#include "client_agent/live/push/push_message.h"

#include <algorithm>
#include <cstring>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client_agent/push_client/corbslam/push.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr uint32_t kMostPixels = 16384;  // Of a side.
constexpr uint64_t kMostMemoryBytes = uint64_t{1} << 31;
constexpr int64_t kMostTime_ns = int64_t{1} << 62;

absl::Status Bad(absl::string_view field, uint64_t value, absl::string_view wanted) {
  return absl::InvalidArgumentError(absl::StrCat(field, " is ", value, ", must be ", wanted));
}

// Copies the front of a packet, whose kind and size are checked.
template <typename Message>
absl::StatusOr<Message> Front(absl::string_view packet, push_wire::Kind kind,
                              absl::string_view name) {
  push_wire::Header header = {};
  if (packet.size() < sizeof(header)) {
    return Bad("bytes", packet.size(), "8 at least, which a message's header has");
  }
  std::memcpy(&header, packet.data(), sizeof(header));
  if (header.kind != kind) {
    return Bad("kind", header.kind, absl::StrCat(kind, " (", name, ")"));
  }
  if (packet.size() < sizeof(Message)) {
    return Bad("bytes", packet.size(), absl::StrCat(sizeof(Message), " at least in a ", name));
  }
  if (header.bytes != packet.size()) {
    return Bad("header.bytes", header.bytes, absl::StrCat(packet.size(), ", the packet's size"));
  }
  Message message;
  std::memcpy(&message, packet.data(), sizeof(message));
  return message;
}

// The numbers are small enough that none of this overflows.
absl::Status CheckPicture(const std::string& which, const push_wire::Picture& picture,
                          uint64_t slot_bytes) {
  const uint32_t pixel = push_wire::BytesPerPixel(picture.format);
  if (pixel == 0) {
    return Bad(which + ".format", picture.format, "1 grey8, 2 grey16, 3 bgr8 or 4 depth16");
  }
  const std::string sizes = absl::StrCat("1 to ", kMostPixels);
  if (picture.width_px < 1 || picture.width_px > kMostPixels) {
    return Bad(which + ".width_px", picture.width_px, sizes);
  }
  if (picture.height_px < 1 || picture.height_px > kMostPixels) {
    return Bad(which + ".height_px", picture.height_px, sizes);
  }
  const uint64_t row = uint64_t{picture.width_px} * pixel;
  if (picture.stride_bytes < row || picture.stride_bytes > 4 * kMostPixels) {
    return Bad(which + ".stride_bytes", picture.stride_bytes,
               absl::StrCat(row, " to ", 4 * kMostPixels));
  }
  if (pixel == 2 && picture.stride_bytes % 2 != 0) {
    return Bad(which + ".stride_bytes", picture.stride_bytes, "even, with pixels of 16 bits");
  }
  const uint64_t bytes = uint64_t{picture.stride_bytes} * (picture.height_px - 1) + row;
  if (bytes > slot_bytes || picture.offset_bytes > slot_bytes - bytes) {
    return Bad(which + ".offset_bytes", picture.offset_bytes,
               absl::StrCat("such that its ", bytes, " bytes end within slot_bytes, ", slot_bytes));
  }
  if (picture.offset_bytes % 16 == 0) return absl::OkStatus();
  return Bad(which + ".offset_bytes", picture.offset_bytes, "a multiple of 16");
}

bool IsNone(const push_wire::Picture& picture) {
  return picture.format == 0 && picture.width_px == 0 && picture.height_px == 0 &&
         picture.stride_bytes == 0 && picture.offset_bytes == 0;
}

absl::Status CheckLayout(const PushLayout& layout) {
  if (layout.slots < 1 || layout.slots > push_wire::kMostSlots) {
    return Bad("slots", layout.slots, absl::StrCat("1 to ", push_wire::kMostSlots));
  }
  if (layout.memory_bytes > kMostMemoryBytes) {
    return Bad("memory_bytes", layout.memory_bytes, absl::StrCat("at most ", kMostMemoryBytes));
  }
  if (layout.slot_bytes % 16 != 0) {
    return Bad("slot_bytes", layout.slot_bytes, "a multiple of 16");
  }
  if (layout.slot_bytes > layout.memory_bytes / layout.slots) {
    return Bad(
        "memory_bytes", layout.memory_bytes,
        absl::StrCat("at least slots * slot_bytes, ", layout.slots, " * ", layout.slot_bytes));
  }
  RETURN_IF_ERROR(CheckPicture("first", layout.first, layout.slot_bytes));
  if (IsNone(layout.second)) return absl::OkStatus();
  return CheckPicture("second", layout.second, layout.slot_bytes);
}

absl::StatusOr<std::string> ReadName(const push_wire::Hello& hello) {
  const auto* const end = static_cast<const char*>(std::memchr(hello.name, 0, sizeof(hello.name)));
  if (end == nullptr) return absl::InvalidArgumentError("name does not end with a zero");
  std::string name(hello.name, end);
  // It goes into the log.
  for (char& letter : name) {
    if (absl::ascii_iscntrl(static_cast<unsigned char>(letter))) letter = '?';
  }
  return name;
}

absl::Status CheckFormat(const std::string& which, uint32_t format, bool depth) {
  if (format == 0) {
    return Bad(
        which + ".format", format,
        "1 to 4: a frame has two pictures, unless the rig is of one camera (kind: monocular)");
  }
  if ((format == CORBSLAM_PUSH_DEPTH16) == depth) return absl::OkStatus();
  return Bad(which + ".format", format,
             depth ? "4 (depth16): the rig is of an RGB-D camera"
                   : "1 (grey8), 2 (grey16) or 3 (bgr8): the rig has no depth there");
}

absl::Status CheckSize(const std::string& which, const push_wire::Picture& picture,
                       const RigCamera& camera) {
  if (picture.width_px != static_cast<uint32_t>(camera.width_px)) {
    return Bad(which + ".width_px", picture.width_px, absl::StrCat(camera.width_px, ", the rig's"));
  }
  if (picture.height_px == static_cast<uint32_t>(camera.height_px)) return absl::OkStatus();
  return Bad(which + ".height_px", picture.height_px,
             absl::StrCat(camera.height_px, ", the rig's"));
}

template <typename Message>
std::string ToBytes(const Message& message) {
  std::string bytes(sizeof(message), 0);
  std::memcpy(bytes.data(), &message, sizeof(message));
  return bytes;
}

uint32_t StateOf(const FramePose& pose) {
  if (pose.local_from_camera.has_value()) return CORBSLAM_PUSH_TRACKING;
  return pose.is_lost ? CORBSLAM_PUSH_LOST : CORBSLAM_PUSH_NOT_INITIALISED;
}

}  // namespace

absl::StatusOr<PushHello> ParseHello(absl::string_view packet) {
  ASSIGN_OR_RETURN(const auto hello, Front<push_wire::Hello>(packet, push_wire::kHello, "hello"));
  if (hello.magic != push_wire::kMagic) {
    return Bad("magic", hello.magic, absl::StrCat(push_wire::kMagic, ", \"PUSH\" in memory"));
  }
  if (hello.version != push_wire::kVersion) {
    return Bad("version", hello.version,
               absl::StrCat(push_wire::kVersion, ", which this robot speaks"));
  }
  if (hello.rig_bytes > push_wire::kMostRigBytes ||
      hello.rig_bytes != packet.size() - sizeof(hello)) {
    return Bad("rig_bytes", hello.rig_bytes,
               absl::StrCat("what follows the hello, ", packet.size() - sizeof(hello),
                            ", and at most ", push_wire::kMostRigBytes));
  }
  PushHello parsed;
  parsed.layout = {hello.slots, hello.slot_bytes, hello.memory_bytes, hello.first, hello.second};
  RETURN_IF_ERROR(CheckLayout(parsed.layout));
  ASSIGN_OR_RETURN(parsed.name, ReadName(hello));
  parsed.rig_text = std::string(packet.substr(sizeof(hello)));
  return parsed;
}

absl::StatusOr<PushFrame> ParseFrame(absl::string_view packet, const PushLayout& layout) {
  ASSIGN_OR_RETURN(const auto frame, Front<push_wire::Frame>(packet, push_wire::kFrame, "frame"));
  if (packet.size() != sizeof(frame)) {
    return Bad("bytes", packet.size(), absl::StrCat(sizeof(frame), " in a frame"));
  }
  if (frame.slot >= layout.slots) {
    return Bad("slot", frame.slot, absl::StrCat("below ", layout.slots));
  }
  if (frame.reserved != 0) return Bad("reserved", frame.reserved, "0");
  if (frame.timestamp_ns < 0 || frame.timestamp_ns > kMostTime_ns) {
    return absl::InvalidArgumentError(
        absl::StrCat("timestamp_ns is ", frame.timestamp_ns, ", must be 0 to 2^62"));
  }
  return PushFrame{frame.slot, frame.timestamp_ns};
}

bool IsImu(absl::string_view packet) {
  push_wire::Header header = {};
  if (packet.size() < sizeof(header)) return false;
  std::memcpy(&header, packet.data(), sizeof(header));
  return header.kind == push_wire::kImu;
}

absl::StatusOr<ImuSamples> ParseImu(absl::string_view packet) {
  ASSIGN_OR_RETURN(const auto head, Front<push_wire::Imu>(packet, push_wire::kImu, "imu"));
  if (head.samples < 1 || head.samples > push_wire::kMostImuSamples) {
    return Bad("samples", head.samples, absl::StrCat("1 to ", push_wire::kMostImuSamples));
  }
  if (packet.size() != sizeof(head) + head.samples * sizeof(push_wire::ImuSample)) {
    return Bad("bytes", packet.size(),
               absl::StrCat(sizeof(head) + head.samples * sizeof(push_wire::ImuSample), " with ",
                            head.samples, " samples"));
  }
  if (head.reserved != 0) return Bad("reserved", head.reserved, "0");
  ImuSamples samples;
  for (uint32_t i = 0; i < head.samples; ++i) {
    push_wire::ImuSample sent;
    std::memcpy(&sent, packet.data() + sizeof(head) + i * sizeof(sent), sizeof(sent));
    const ImuSample sample = {sent.timestamp_ns, Eigen::Vector3d(sent.angular_velocity_rps),
                              Eigen::Vector3d(sent.specific_force_mps2)};
    if (!sample.angular_velocity_rps.allFinite() || !sample.specific_force_mps2.allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrCat("the sample of ", sent.timestamp_ns, " ns has a value that is not finite"));
    }
    if (sent.timestamp_ns < 0 || sent.timestamp_ns > kMostTime_ns) {
      return absl::InvalidArgumentError(
          absl::StrCat("a sample's timestamp_ns is ", sent.timestamp_ns, ", must be 0 to 2^62"));
    }
    if (!samples.empty() && sent.timestamp_ns <= samples.back().timestamp_ns) {
      return absl::InvalidArgumentError(
          absl::StrCat("a sample's timestamp_ns is ", sent.timestamp_ns, ", the one before has ",
                       samples.back().timestamp_ns, ": times must grow"));
    }
    samples.push_back(sample);
  }
  return samples;
}

absl::Status CheckPictures(const PushLayout& layout, const Rig& rig) {
  const bool rgbd = rig.kind == RigKind::kRgbd;
  RETURN_IF_ERROR(CheckFormat("first", layout.first.format, false));
  RETURN_IF_ERROR(CheckSize("first", layout.first, rig.cameras.front()));
  if (rig.kind == RigKind::kMonocular) {
    if (IsNone(layout.second)) return absl::OkStatus();
    return Bad("second.format", layout.second.format,
               "0, as all of second: the rig is of one camera (kind: monocular)");
  }
  RETURN_IF_ERROR(CheckFormat("second", layout.second.format, rgbd));
  return CheckSize("second", layout.second, rig.cameras.back());
}

std::string FormatWelcome(bool takes_imu) {
  return ToBytes(push_wire::Welcome{{push_wire::kWelcome, sizeof(push_wire::Welcome)},
                                    push_wire::kVersion,
                                    takes_imu ? push_wire::kTakesImu : 0});
}

std::string FormatSlotsFree(uint64_t slots) {
  return ToBytes(
      push_wire::SlotsFree{{push_wire::kSlotsFree, sizeof(push_wire::SlotsFree)}, slots});
}

std::string FormatPose(const FramePose& pose) {
  push_wire::Pose message = {};
  message.header = {push_wire::kPose, sizeof(message)};
  message.timestamp_ns = pose.timestamp_ns;
  message.state = StateOf(pose);
  message.points_matched = static_cast<uint32_t>(std::max(pose.points_matched, 0));
  message.local_map = pose.local_map.value;
  message.dropped = pose.dropped;
  if (pose.local_from_camera.has_value()) {
    const Rigid3d& local_from_camera = *pose.local_from_camera;
    std::copy_n(local_from_camera.translation.data(), 3, message.translation);
    // Eigen keeps x, y, z, w.
    std::copy_n(local_from_camera.rotation.coeffs().data(), 4, message.rotation);
  }
  return ToBytes(message);
}

std::string FormatRefusal(absl::string_view why) {
  why = why.substr(0, push_wire::kMostTextBytes);
  const auto bytes = static_cast<uint32_t>(sizeof(push_wire::Refused) + why.size());
  return absl::StrCat(ToBytes(push_wire::Refused{{push_wire::kRefused, bytes}}), why);
}

}  // namespace corbslam::client_agent
