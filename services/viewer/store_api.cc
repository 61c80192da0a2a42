#include "services/viewer/store_api.h"

#include <google/protobuf/util/json_util.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "slam/exchange/uplink.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kMaxStreamBytes = size_t{128} << 20;

int HttpStatusOf(const absl::Status& error) {
  switch (error.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kResourceExhausted:
      return 429;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
      return 503;
    default:
      return 502;
  }
}

absl::StatusOr<WebResponse> ToJson(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto status = google::protobuf::util::MessageToJsonString(message, &json, options);
  if (!status.ok()) return absl::InternalError(std::string(status.message()));
  WebResponse response;
  response.content_type = "application/json";
  response.body = std::make_shared<const std::string>(std::move(json));
  return response;
}

std::string Find(const WebRequest& request, const std::string& name) {
  const auto it = request.query.find(name);
  return it == request.query.end() ? "" : it->second;
}

// Returns 0 where the field is not given.
absl::StatusOr<int> FindNumber(const WebRequest& request, const std::string& name) {
  const std::string text = Find(request, name);
  int number = 0;
  if (text.empty() || (absl::SimpleAtoi(text, &number) && number >= 0)) return number;
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is \"", text.substr(0, 100), "\", must be a number"));
}

template <typename Request>
absl::Status SetPage(const WebRequest& web, Request& request) {
  ASSIGN_OR_RETURN(const int size, FindNumber(web, "pageSize"));
  request.set_page_size(size);
  request.set_page_token(Find(web, "pageToken"));
  return absl::OkStatus();
}

std::string TokenOf(const WebRequest& request) {
  absl::string_view token = request.authorization;
  if (absl::StartsWithIgnoreCase(token, "bearer ")) token.remove_prefix(7);
  return std::string(token);
}

// Reads all messages of a stream, each behind its length in four bytes, the least significant
// first. The answer counts in `memory` until it is sent.
template <typename Message, typename Reader>
absl::StatusOr<WebResponse> Collect(grpc::ClientContext& context, Reader& reader,
                                    absl::string_view call, AnswerMemory& memory) {
  AnswerMemory::Body body = memory.Begin();
  Message message;
  absl::Status room;
  while (room.ok() && body.size() < kMaxStreamBytes && reader.Read(&message)) {
    room = body.AddMessage(message.SerializeAsString());
  }
  if (room.ok() && body.size() >= kMaxStreamBytes) {
    room = absl::ResourceExhaustedError(
        absl::StrCat(call, " has more than ", kMaxStreamBytes, " bytes; ask for less"));
  }
  if (!room.ok()) context.TryCancel();
  const absl::Status ended = ToStatus(reader.Finish(), call);
  RETURN_IF_ERROR(room);
  RETURN_IF_ERROR(ended);
  WebResponse response;
  response.content_type = "application/octet-stream";
  response.body = std::move(body).Take();
  return response;
}

}  // namespace

WebResponse ToResponse(const absl::Status& error) {
  WebResponse response;
  response.status = HttpStatusOf(error);
  response.content_type = "application/json";
  // What is no UTF-8 is replaced.
  response.body = std::make_shared<const std::string>(
      nlohmann::json{{"error", std::string(error.message())}}.dump(
          -1, ' ', false, nlohmann::json::error_handler_t::replace));
  return response;
}

WebResponse StoreApi::Answer(const WebRequest& request) {
  Answered answer;
  try {
    answer = AnswerOrError(request);
  } catch (const std::exception& error) {
    // Most likely memory is short; the next one may be answered.
    answer =
        absl::ResourceExhaustedError(absl::StrCat("the answer could not be made: ", error.what()));
  }
  if (!answer.ok()) return ToResponse(answer.status());
  answer->headers.try_emplace("Cache-Control", "no-store");
  return *std::move(answer);
}

StoreApi::Answered StoreApi::AnswerOrError(const WebRequest& request) {
  const std::vector<std::string> path =
      absl::StrSplit(absl::StripPrefix(request.path, "/api/"), '/');
  if (path[0] != "missions") {
    return absl::NotFoundError(absl::StrCat("there is no ", request.path.substr(0, 200)));
  }
  if (path.size() == 1) return ListMissions(request);
  RETURN_IF_ERROR(CheckNameSegment("mission", path[1]));
  RETURN_IF_ERROR(access_.CheckMission(TokenOf(request), path[1]));
  if (ask_store_ != nullptr) RETURN_IF_ERROR(ask_store_(TokenOf(request), path[1]));
  return OfMission(path[1], {path.begin() + 2, path.end()}, request);
}

StoreApi::Answered StoreApi::ListMissions(const WebRequest& request) {
  ASSIGN_OR_RETURN(const std::optional<std::set<std::string>> missions,
                   access_.MissionsOf(TokenOf(request)));
  if (ask_store_ != nullptr) {
    const std::string any = missions && !missions->empty() ? *missions->begin() : "-";
    RETURN_IF_ERROR(ask_store_(TokenOf(request), any));
  }
  v1::ListMissionsResponse response;
  if (!missions) {
    grpc::ClientContext context;
    SetDeadline(context);
    v1::ListMissionsRequest ask;
    RETURN_IF_ERROR(SetPage(request, ask));
    const auto store = v1::MapStore::NewStub(routes_->named());
    RETURN_IF_ERROR(ToStatus(store->ListMissions(&context, ask, &response), "ListMissions"));
    return ToJson(response);
  }
  // A token may name many missions; all of them together get the time of one call.
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  for (const std::string& mission : *missions) {
    v1::GetMissionRequest ask;
    ask.set_name(MissionName(mission));
    v1::Mission found;
    const absl::Status asked = routes_->Of(mission)->Ask([&](Store& store) {
      grpc::ClientContext context;
      context.set_deadline(absl::ToChronoTime(deadline));
      return ToStatus(store.GetMission(&context, ask, &found), "GetMission");
    });
    if (asked.ok()) *response.add_missions() = found;
  }
  return ToJson(response);
}

StoreApi::Answered StoreApi::OfMission(const std::string& mission,
                                       const std::vector<std::string>& rest,
                                       const WebRequest& request) {
  Answered answer;
  const absl::Status asked = routes_->Of(mission)->Ask([&](Store& store) {
    answer = AskOne(store, mission, rest, request);
    return answer.status();
  });
  RETURN_IF_ERROR(asked);
  return answer;
}

StoreApi::Answered StoreApi::AskOne(Store& store, const std::string& mission,
                                    const std::vector<std::string>& rest,
                                    const WebRequest& request) {
  if (rest.empty()) return GetMission(store, mission);
  if (rest.size() == 1) {
    if (rest[0] == "agents") return ListAgents(store, mission, request);
    if (rest[0] == "localMaps") return ListLocalMaps(store, mission, request);
    if (rest[0] == "overlaps") return ListOverlaps(store, mission, request);
    if (rest[0] == "trajectory") return GetTrajectory(store, mission, request);
    if (rest[0] == "history") return GetHistory(store, mission, request);
    if (rest[0] == "truth") return GetTruth(mission);
  }
  if (rest.size() == 4 && rest[0] == "localMaps" && rest[2] == "keyframes") {
    return GetKeyframe(store, absl::StrCat(MissionName(mission), "/", absl::StrJoin(rest, "/")),
                       request);
  }
  if (rest.size() == 5 && rest[0] == "localMaps" && rest[2] == "keyframes" &&
      rest[4] == "picture") {
    return GetPicture(store, absl::StrCat(MissionName(mission), "/",
                                          absl::StrJoin(rest.begin(), rest.begin() + 4, "/")));
  }
  if (rest.size() == 2 && rest[0] == "overlaps") {
    return GetOverlap(store, absl::StrCat(MissionName(mission), "/", absl::StrJoin(rest, "/")));
  }
  return absl::NotFoundError(absl::StrCat("there is no ", request.path.substr(0, 200)));
}

StoreApi::Answered StoreApi::GetMission(Store& store, const std::string& mission) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetMissionRequest ask;
  ask.set_name(MissionName(mission));
  v1::Mission response;
  RETURN_IF_ERROR(ToStatus(store.GetMission(&context, ask, &response), "GetMission"));
  return ToJson(response);
}

StoreApi::Answered StoreApi::ListAgents(Store& store, const std::string& mission,
                                        const WebRequest& request) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::ListAgentsRequest ask;
  ask.set_parent(MissionName(mission));
  RETURN_IF_ERROR(SetPage(request, ask));
  v1::ListAgentsResponse response;
  RETURN_IF_ERROR(ToStatus(store.ListAgents(&context, ask, &response), "ListAgents"));
  return ToJson(response);
}

StoreApi::Answered StoreApi::ListLocalMaps(Store& store, const std::string& mission,
                                           const WebRequest& request) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::ListLocalMapsRequest ask;
  ask.set_parent(MissionName(mission));
  RETURN_IF_ERROR(SetPage(request, ask));
  v1::ListLocalMapsResponse response;
  RETURN_IF_ERROR(ToStatus(store.ListLocalMaps(&context, ask, &response), "ListLocalMaps"));
  return ToJson(response);
}

StoreApi::Answered StoreApi::ListOverlaps(Store& store, const std::string& mission,
                                          const WebRequest& request) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::ListOverlapsRequest ask;
  ask.set_parent(MissionName(mission));
  ask.set_accepted_only(Find(request, "acceptedOnly") == "true");
  RETURN_IF_ERROR(SetPage(request, ask));
  v1::ListOverlapsResponse response;
  RETURN_IF_ERROR(ToStatus(store.ListOverlaps(&context, ask, &response), "ListOverlaps"));
  return ToJson(response);
}

StoreApi::Answered StoreApi::GetKeyframe(Store& store, const std::string& name,
                                         const WebRequest& request) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetKeyframeRequest ask;
  ask.set_name(name);
  if (Find(request, "view") == "full") ask.set_view(v1::KEYFRAME_VIEW_FULL);
  v1::Keyframe response;
  RETURN_IF_ERROR(ToStatus(store.GetKeyframe(&context, ask, &response), "GetKeyframe"));
  return ToJson(response);
}

StoreApi::Answered StoreApi::GetPicture(Store& store, const std::string& name) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetKeyframeRequest ask;
  ask.set_name(name);
  ask.set_view(v1::KEYFRAME_VIEW_PICTURE);
  v1::Keyframe keyframe;
  RETURN_IF_ERROR(ToStatus(store.GetKeyframe(&context, ask, &keyframe), "GetKeyframe"));
  const size_t bytes = keyframe.picture().size();
  if (bytes > kMaxPictureBytes) {
    return absl::InternalError(absl::StrCat("the map store's picture has ", bytes,
                                            " bytes; the limit is ", kMaxPictureBytes));
  }
  WebResponse response;
  // That there is none is no error; one may still come.
  if (bytes == 0) return response;
  response.content_type = "image/jpeg";
  response.body = std::make_shared<const std::string>(std::move(*keyframe.mutable_picture()));
  response.headers["Picture-Scale"] = absl::StrCat(keyframe.picture_scale());
  // A keyframe's picture never changes; who may see it may.
  response.headers["Cache-Control"] = "private, max-age=600";
  response.headers["Vary"] = "Authorization";
  return response;
}

StoreApi::Answered StoreApi::GetOverlap(Store& store, const std::string& name) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetOverlapRequest ask;
  ask.set_name(name);
  v1::Overlap response;
  RETURN_IF_ERROR(ToStatus(store.GetOverlap(&context, ask, &response), "GetOverlap"));
  return ToJson(response);
}

StoreApi::Answered StoreApi::GetTrajectory(Store& store, const std::string& mission,
                                           const WebRequest& request) {
  const std::string frame = Find(request, "frame");
  if (frame != "" && frame != "global" && frame != "local") {
    return absl::InvalidArgumentError(
        absl::StrCat("frame is \"", frame.substr(0, 100), "\", must be global or local"));
  }
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetTrajectoryRequest ask;
  ask.set_name(AgentName(mission, "-"));
  ask.set_frame(frame == "local" ? v1::TRAJECTORY_FRAME_LOCAL : v1::TRAJECTORY_FRAME_GLOBAL);
  ask.set_all_islands(true);
  ask.set_poses_of(v1::POSES_OF_RECTIFIED_CAMERA);
  const auto reader = store.GetTrajectory(&context, ask);
  return Collect<v1::GetTrajectoryResponse>(context, *reader, "GetTrajectory", memory_);
}

StoreApi::Answered StoreApi::GetHistory(Store& store, const std::string& mission,
                                        const WebRequest& request) {
  v1::ReplayMapRequest ask;
  ask.set_mission(MissionName(mission));
  ask.set_include_points(Find(request, "points") == "1");
  ASSIGN_OR_RETURN(const int max, FindNumber(request, "max"));
  ask.set_max_moments(static_cast<uint32_t>(max));
  const absl::StatusOr<std::shared_ptr<const void>> slot = replays_.Enter("", MissionName(mission));
  RETURN_IF_ERROR(slot.status());
  grpc::ClientContext context;
  SetDeadline(context);
  const auto reader = store.ReplayMap(&context, ask);
  return Collect<v1::WatchMapResponse>(context, *reader, "ReplayMap", memory_);
}

StoreApi::Answered StoreApi::GetTruth(const std::string& mission) const {
  WebResponse response;
  response.content_type = "text/plain; charset=utf-8";
  const auto truth = truths_.find(mission);
  // That there is none is no error: it is so of most missions.
  response.body = truth == truths_.end() ? std::make_shared<const std::string>() : truth->second;
  return response;
}

}  // namespace corbslam::services
