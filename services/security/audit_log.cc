#include "services/security/audit_log.h"

#include <glog/logging.h>
#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/convert/asked_resource.h"
#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "services/map_store_service/streams/stream_limits.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

constexpr absl::string_view kSync = "corbslam.v1.MapStore/Sync";
// What a caller says is cut after so many bytes.
constexpr size_t kMaxText = 300;
// A message that opens a session is shorter.
constexpr size_t kMaxOpenBytes = 64 << 10;

std::string Shortened(absl::string_view text) {
  if (text.size() <= kMaxText) return std::string(text);
  return absl::StrCat(text.substr(0, kMaxText), "...");
}

bool IsAdministrative(absl::string_view method) {
  const std::optional<Action> action = ActionOf(absl::StrCat("/", method));
  return action == Action::kAdminister || action == Action::kCommand;
}

// Returns the mission and the agent that a session's first message names.
std::string ResourceOfSession(const grpc::ByteBuffer& message) {
  if (message.Length() > kMaxOpenBytes) return "";
  // Reading takes the buffer's parts away, but not from other buffers that have them, too.
  grpc::ByteBuffer copy = message;
  v1::SyncRequest request;
  if (!grpc::SerializationTraits<v1::SyncRequest>::Deserialize(&copy, &request).ok()) return "";
  if (!request.has_open()) return "";
  return absl::StrCat(request.open().mission(), "/agents/", request.open().agent());
}

}  // namespace

std::string ToString(RefusalKind kind) {
  switch (kind) {
    case RefusalKind::kUnauthenticated:
      return "unauthenticated";
    case RefusalKind::kPermissionDenied:
      return "permission_denied";
    case RefusalKind::kResourceExhausted:
      return "resource_exhausted";
    case RefusalKind::kInvalidSession:
      return "invalid_session";
  }
  return "";
}

std::optional<RefusalKind> RefusalOf(absl::string_view method, absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kUnauthenticated:
      return RefusalKind::kUnauthenticated;
    case absl::StatusCode::kPermissionDenied:
      return RefusalKind::kPermissionDenied;
    case absl::StatusCode::kResourceExhausted:
      return RefusalKind::kResourceExhausted;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kAlreadyExists:
      if (method == kSync) return RefusalKind::kInvalidSession;
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

AuditCounts& ProcessAuditCounts() {
  static auto& counts = *new AuditCounts();
  return counts;
}

absl::StatusOr<std::shared_ptr<AuditLog>> AuditLog::Open(
    const AuditLogOptions& options, std::shared_ptr<const AccessControl> access) {
  std::shared_ptr<AuditLog> log(new AuditLog(options, std::move(access)));
  if (options.file.empty() || options.file == "-") return log;
  absl::StatusOr<std::unique_ptr<AuditFile>> file =
      AuditFile::Open(options.file, options.max_bytes);
  if (!file.ok()) return file.status();
  absl::MutexLock lock(&log->mutex_);
  log->file_ = *std::move(file);
  return log;
}

AuditLog::~AuditLog() {
  absl::MutexLock lock(&mutex_);
  SayWhatWasLeftOut(absl::InfiniteFuture());
}

std::string AuditLog::OnAsked(absl::string_view method, const grpc::ServerContextBase& context,
                              const void* message) {
  if (method != kSync) {
    // All messages of generated classes have this base first.
    const google::protobuf::MethodDescriptor* asked = FindMethod(absl::StrCat("/", method));
    if (asked == nullptr) return "";
    return ResourceOf(*asked, *static_cast<const google::protobuf::Message*>(message));
  }
  std::string resource = ResourceOfSession(*static_cast<const grpc::ByteBuffer*>(message));
  Write({"session_asked", context.peer(), EvidenceOf(context), "", std::string(method), resource,
         std::nullopt});
  return resource;
}

void AuditLog::OnEnded(const EndedCall& call) {
  const absl::Status answer = FromGrpcStatus(call.status);
  const std::optional<RefusalKind> refusal = RefusalOf(call.method, answer.code());
  const bool is_session = call.method == kSync;
  if (!refusal && !is_session && !IsAdministrative(call.method)) return;
  const Line line = {refusal      ? "refused"
                     : is_session ? "session_ended"
                                  : "administered",
                     call.context->peer(),
                     EvidenceOf(*call.context),
                     "",
                     std::string(call.method),
                     call.resource,
                     answer};
  return refusal ? WriteRefusal(*refusal, line) : Write(line);
}

void AuditLog::OnOwnDoing(absl::string_view event, absl::string_view resource,
                          absl::string_view why) {
  if (options_.file.empty()) return;
  const absl::Time now = absl::Now();
  const Json json = {{"time", absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", now, absl::UTCTimeZone())},
                     {"event", std::string(event)},
                     {"resource", Shortened(resource)},
                     {"message", Shortened(why)}};
  absl::MutexLock lock(&mutex_);
  SayWhatWasLeftOut(now);
  WriteText(json.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace));
}

void AuditLog::OnTurnedAway(absl::string_view method, const Evidence& evidence,
                            absl::string_view user_agent, const absl::Status& status) {
  const std::optional<RefusalKind> refusal = RefusalOf(method, status.code());
  if (!refusal) return;
  WriteRefusal(*refusal,
               {"refused", "", evidence, std::string(user_agent), std::string(method), "", status});
}

std::string AuditLog::ToJson(const Line& line, absl::Time now) const {
  Json json = {{"time", absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", now, absl::UTCTimeZone())},
               {"event", line.event}};
  const absl::StatusOr<Identity> identity =
      access_ == nullptr ? absl::UnauthenticatedError("without TLS nobody is known")
                         : access_->Identify(line.evidence, now);
  if (identity.ok()) json["identity"] = Describe(*identity);
  if (identity.ok() && !identity->token_id.empty()) json["token"] = identity->token_id;
  // Who is not known may still have shown a good certificate, with a bad token.
  if (!identity.ok() && !line.evidence.uris.empty()) {
    json["certificate"] = Shortened(line.evidence.uris.front());
  }
  if (!line.peer.empty()) json["peer"] = Shortened(line.peer);
  if (!line.user_agent.empty()) json["user_agent"] = Shortened(line.user_agent);
  json["call"] = Shortened(line.method);
  if (!line.resource.empty()) json["resource"] = Shortened(line.resource);
  if (line.answer) {
    json["code"] = absl::StatusCodeToString(line.answer->code());
    if (!line.answer->message().empty()) json["message"] = Shortened(line.answer->message());
  }
  return json.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace);
}

void AuditLog::WriteRefusal(RefusalKind kind, const Line& line) {
  ++ProcessAuditCounts().refused[static_cast<size_t>(kind)];
  if (options_.file.empty()) return;
  const absl::Time now = absl::Now();
  {
    absl::MutexLock lock(&mutex_);
    SayWhatWasLeftOut(now);
    const std::string host = line.peer.empty() ? "unknown" : HostOfPeer(line.peer);
    if (!limiter_.Admit(host, now)) {
      ++ProcessAuditCounts().left_out;
      return;
    }
  }
  Write(line);
}

void AuditLog::Write(const Line& line) {
  if (options_.file.empty()) return;
  const absl::Time now = absl::Now();
  const std::string json = ToJson(line, now);
  absl::MutexLock lock(&mutex_);
  SayWhatWasLeftOut(now);
  WriteText(json);
}

void AuditLog::SayWhatWasLeftOut(absl::Time now) {
  for (const RefusalLimiter::LeftOut& left_out : limiter_.TakeOver(now)) {
    const Json json = {
        {"time", absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", left_out.since, absl::UTCTimeZone())},
        {"event", "left_out"},
        {"peer", left_out.peer},
        {"refusals", left_out.count}};
    WriteText(json.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace));
  }
}

void AuditLog::WriteText(const std::string& json) {
  if (file_ == nullptr) {
    if (options_.file.empty()) return;
    LOG(INFO) << "audit: " << json;
    ++ProcessAuditCounts().written;
    return;
  }
  const absl::Status written = file_->Append(json);
  ++(written.ok() ? ProcessAuditCounts().written : ProcessAuditCounts().failed);
  if (written.ok()) {
    failing_.Reset();
  } else if (failing_.IsDue(absl::Now())) {
    LOG(ERROR) << "--audit-log: " << written.message() << "; lines are lost";
  }
}

}  // namespace corbslam::services
