#include "tests/fault/attacks.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/client/remote/channel.h"
#include "services/convert/map_update.h"
#include "services/convert/resource_names.h"
#include "tests/fault/raw_stream.h"

namespace corbslam::tests {

using services::CameraBook;
using services::MakeChannel;
using services::MissionName;
using services::ToProto;

namespace {

constexpr char kOwnAgent[] = "mallory";
constexpr LocalMapId kOwnMap{0xbad};
// Messages of one stream before it is given up.
constexpr int kMessagesOfAStream = 20;
// Calls at once. gRPC itself would keep some of a larger number back.
constexpr int kCallsOfAConnection = 100;
constexpr absl::Duration kPatience = absl::Seconds(10);

std::string NameOf(const std::optional<absl::Status>& end) {
  return end.has_value() ? absl::StatusCodeToString(end->code()) : "open";
}

// Returns a socket connected to "HOST:PORT", or -1 where that fails.
int Connect(const std::string& address) {
  const size_t colon = address.rfind(':');
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(address.substr(0, colon).c_str(), address.substr(colon + 1).c_str(), &hints,
                  &found) != 0) {
    return -1;
  }
  const int fd = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool connected = fd >= 0 && connect(fd, found->ai_addr, found->ai_addrlen) == 0;
  freeaddrinfo(found);
  if (connected) return fd;
  if (fd >= 0) close(fd);
  return -1;
}

std::string Frame(char type, char flags, char stream, const std::string& payload) {
  std::string frame;
  for (const int shift : {16, 8, 0}) frame += static_cast<char>(payload.size() >> shift);
  frame += type;
  frame += flags;
  frame += std::string(3, '\0');
  frame += stream;
  return frame + payload;
}

// Returns whether one of the frames ends a stream: the last headers, or a reset.
bool EndsStream(const std::string& frames) {
  constexpr size_t kHeadBytes = 9;
  size_t at = 0;
  while (at + kHeadBytes <= frames.size()) {
    const auto byte = [&](size_t i) { return static_cast<uint8_t>(frames[at + i]); };
    const size_t length = (size_t{byte(0)} << 16) + (size_t{byte(1)} << 8) + byte(2);
    const bool is_last_headers = byte(3) == 1 && (byte(4) & 1) != 0;
    if (is_last_headers || byte(3) == 3) return true;
    at += kHeadBytes + length;
  }
  return false;
}

// Encodes a header without compression (RFC 7541, 6.2.2) and with a new name.
std::string Header(const std::string& name, const std::string& value) {
  std::string header(1, '\0');
  header += static_cast<char>(name.size());
  header += name;
  header += static_cast<char>(value.size());
  return header + value;
}

}  // namespace

Attacker::Attacker(std::string address, std::string mission, LocalMapId victim,
                   const RecordedUploads* uploads, uint64_t seed)
    : address_(std::move(address)),
      mission_(std::move(mission)),
      victim_(victim),
      uploads_(*uploads),
      random_(seed) {}

std::string Attacker::OpenMessage(const std::string& mission, const std::string& agent) const {
  v1::SyncRequest request;
  request.mutable_open()->set_mission(MissionName(mission));
  request.mutable_open()->set_agent(agent);
  return request.SerializeAsString();
}

std::string Attacker::BatchMessage(const MapUpdateBatch& batch) const {
  CameraBook cameras;
  v1::SyncRequest request;
  *request.mutable_batch() = ToProto(batch, cameras, 4 << 20).front();
  return request.SerializeAsString();
}

std::string Attacker::Mutate(std::string bytes) {
  const auto pick = [this](size_t end) {
    return std::uniform_int_distribution<size_t>(0, end - 1)(random_);
  };
  const size_t way = pick(5);
  if (way == 0) return bytes.substr(0, pick(bytes.size()));
  if (way == 1) return bytes + bytes.substr(pick(bytes.size()));
  if (way == 2) {
    std::string made_up(1 + pick(2000), '\0');
    for (char& byte : made_up) byte = static_cast<char>(pick(256));
    return made_up;
  }
  const size_t changes = 1 + pick(way == 3 ? 3 : 200);
  // The first bytes hold most of the structure.
  const size_t end = pick(2) == 0 ? std::min<size_t>(bytes.size(), 200) : bytes.size();
  for (size_t i = 0; i < changes; ++i) bytes[pick(end)] = static_cast<char>(pick(256));
  return bytes;
}

Attacker::Ends Attacker::SendMutatedMessages(int messages) {
  const auto channel = MakeChannel(address_);
  std::vector<std::string> good;
  for (size_t i = 0; i < std::min<size_t>(uploads_.size(), 8); ++i) {
    good.push_back(BatchMessage(AsLocalMap(uploads_[i], kOwnMap)));
  }
  Ends ends;
  for (int sent = 0; sent < messages;) {
    RawStream stream(channel);
    const std::string open = OpenMessage(kOwnMission, kOwnAgent);
    const bool opens_well = random_() % 8 != 0;
    stream.Send(opens_well ? open : Mutate(open));
    ++sent;
    for (int i = 0; i < kMessagesOfAStream && sent < messages && !stream.has_ended(); ++i) {
      stream.Send(Mutate(good[random_() % good.size()]));
      ++sent;
    }
    // Changes may have left all messages acceptable, or a batch unfinished; a message of no kind
    // ends the stream in any case.
    stream.Send("");
    ++ends[NameOf(stream.WaitForEnd(kPatience))];
  }
  return ends;
}

std::string Attacker::TryBatch(const std::string& mission, const std::string& agent,
                               const std::vector<MapUpdateBatch>& batches) const {
  RawStream stream(MakeChannel(address_));
  stream.Send(OpenMessage(mission, agent));
  for (const MapUpdateBatch& batch : batches) stream.Send(BatchMessage(batch));
  return NameOf(stream.WaitForEnd(kPatience));
}

std::map<std::string, std::string> Attacker::SendForbiddenBatches() {
  std::map<std::string, std::string> ends;
  const MapUpdateBatch good = AsLocalMap(uploads_.front(), kOwnMap);
  MapUpdateBatch later = good;
  later.number = 1u << 30;
  ends["another's local map"] =
      TryBatch(mission_, kOwnAgent, {AsLocalMap(uploads_.front(), victim_)});
  ends["another's local map, next number"] =
      TryBatch(mission_, kOwnAgent, {AsLocalMap(uploads_.back(), victim_)});
  ends["a number far ahead"] = TryBatch(kOwnMission, kOwnAgent, {later});
  MapUpdateBatch no_number = good;
  no_number.number = 0;
  ends["no number"] = TryBatch(kOwnMission, kOwnAgent, {no_number});
  MapUpdateBatch not_a_pose = good;
  not_a_pose.light_keyframes.push_back({KeyframeId{kOwnMap, 0}, Rigid3d::Identity(), {}});
  not_a_pose.light_keyframes.back().camera_from_local.translation.x() =
      std::numeric_limits<double>::quiet_NaN();
  ends["a pose that is no number"] = TryBatch(kOwnMission, kOwnAgent, {not_a_pose});
  MapUpdateBatch not_a_point = good;
  not_a_point.light_points.push_back(
      {MapPointId{kOwnMap, 0}, Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity())});
  ends["a point at infinity"] = TryBatch(kOwnMission, kOwnAgent, {not_a_point});
  return ends;
}

Attacker::Ends Attacker::ReplayANumber(int times) {
  RawStream stream(MakeChannel(address_));
  stream.Send(OpenMessage(kOwnMission, kOwnAgent));
  for (int i = 0; i < times; ++i) {
    MapUpdateBatch batch = AsLocalMap(uploads_[static_cast<size_t>(i) % uploads_.size()], kOwnMap);
    batch.number = 1;
    stream.Send(BatchMessage(batch));
  }
  const absl::Time deadline = absl::Now() + kPatience;
  while (stream.acknowledgements() < times && !stream.has_ended() && absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(1));
  }
  return {{"OK", stream.acknowledgements()}};
}

Attacker::Ends Attacker::ClaimTwoGigabytes(absl::Duration patience) {
  return SendRawMessage(0x7fffffff, /*dribbles=*/false, patience);
}

Attacker::Ends Attacker::Dribble(absl::Duration patience) {
  return SendRawMessage(1000, /*dribbles=*/true, patience);
}

Attacker::Ends Attacker::SendRawMessage(uint32_t claimed_bytes, bool dribbles,
                                        absl::Duration patience) {
  const int fd = Connect(address_);
  if (fd < 0) return {{"not connected", 1}};
  const std::string headers = Header(":method", "POST") + Header(":scheme", "http") +
                              Header(":path", "/corbslam.v1.MapStore/Sync") +
                              Header(":authority", "x") +
                              Header("content-type", "application/grpc") + Header("te", "trailers");
  std::string claim(1, '\0');
  for (const int shift : {24, 16, 8, 0}) claim += static_cast<char>(claimed_bytes >> shift);
  const std::string bytes = absl::StrCat("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", Frame(4, 0, 0, ""),
                                         Frame(1, 4, 1, headers), Frame(0, 0, 1, claim + "abc"));
  const auto send_all = [fd](const std::string& what) {
    return send(fd, what.data(), what.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(what.size());
  };
  bool goes_on = send_all(bytes);
  const absl::Time deadline = absl::Now() + patience;
  std::string answer;
  char buffer[4096];
  while (goes_on && absl::Now() < deadline && !EndsStream(answer)) {
    pollfd wait{fd, POLLIN, 0};
    if (poll(&wait, 1, 100) <= 0) {
      if (dribbles) goes_on = send_all(Frame(0, 0, 1, "x"));
      continue;
    }
    const ssize_t read_bytes = read(fd, buffer, sizeof(buffer));
    if (read_bytes <= 0) break;
    answer.append(buffer, static_cast<size_t>(read_bytes));
  }
  close(fd);
  return {{EndsStream(answer) ? "ended" : "open", 1}};
}

Attacker::Ends Attacker::OpenSilentStreams(const std::string& method, int streams,
                                           absl::Duration patience) {
  return MakeCalls(method, "", streams, patience);
}

Attacker::Ends Attacker::FloodWithLookups(int calls, absl::Duration patience) {
  v1::ListKeyframesRequest request;
  request.set_parent(MissionName(mission_) + "/localMaps/-");
  return MakeCalls("ListKeyframes", request.SerializeAsString(), calls, patience);
}

Attacker::Ends Attacker::MakeCalls(const std::string& method, const std::string& message, int calls,
                                   absl::Duration patience) const {
  std::vector<std::unique_ptr<RawStream>> made;
  std::shared_ptr<grpc::Channel> channel;
  for (int i = 0; i < calls; ++i) {
    if (i % kCallsOfAConnection == 0) channel = MakeChannel(address_);
    made.push_back(std::make_unique<RawStream>(channel, method));
    if (!message.empty()) made.back()->Send(message);
  }
  Ends ends;
  const absl::Time deadline = absl::Now() + patience;
  for (const auto& call : made) {
    ++ends[NameOf(call->WaitForEnd(std::max(deadline - absl::Now(), absl::ZeroDuration())))];
  }
  return ends;
}

}  // namespace corbslam::tests
