#include "services/viewer/viewer.h"

#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "services/convert/resource_names.h"

namespace corbslam::services {
namespace {

// Close codes of a WebSocket, as the page knows them.
constexpr uint16_t kUnauthenticated = 4401;
constexpr uint16_t kForbidden = 4403;
constexpr uint16_t kNotFound = 4404;
constexpr uint16_t kBusy = 4429;

// What browsers are told of each answer: the page's own scripts and styles alone count, nobody puts
// it into a frame, and nothing is guessed.
void AddSafety(WebResponse& response) {
  response.headers["Content-Security-Policy"] =
      "default-src 'self'; img-src 'self' data:; connect-src 'self' ws: wss:; object-src 'none'; "
      "base-uri 'none'; frame-ancestors 'none'; form-action 'none'";
  response.headers["X-Content-Type-Options"] = "nosniff";
  response.headers["Referrer-Policy"] = "no-referrer";
}

WebResponse Say(int status, absl::string_view text) {
  WebResponse response;
  response.status = status;
  response.body = std::make_shared<const std::string>(absl::StrCat(text, "\n"));
  return response;
}

// Tells one browser what its mission's feed has.
class FeedStream : public WebStream {
 public:
  FeedStream(std::shared_ptr<MissionFeed> feed, bool with_points, std::function<void()> wake)
      : feed_(std::move(feed)), token_(feed_->AddListener(std::move(wake))) {
    reader_.with_points = with_points;
  }
  ~FeedStream() override { feed_->RemoveListener(token_); }

  std::shared_ptr<const std::string> Next() override { return feed_->Next(reader_); }

 private:
  const std::shared_ptr<MissionFeed> feed_;
  const uint64_t token_;
  FeedReader reader_;
};

OpenedStream Refuse(const absl::Status& status) {
  const uint16_t code = absl::IsUnauthenticated(status)     ? kUnauthenticated
                        : absl::IsPermissionDenied(status)  ? kForbidden
                        : absl::IsResourceExhausted(status) ? kBusy
                                                            : kNotFound;
  return {nullptr, code, std::string(status.message())};
}

}  // namespace

Viewer::Viewer(const std::shared_ptr<grpc::Channel>& store, MissionFeeds::Robots robots,
               std::shared_ptr<const AccessControl> access, absl::StatusOr<PageFiles> page,
               const ViewerOptions& options)
    : access_(std::move(access)),
      page_(std::move(page)),
      feeds_(store, std::move(robots), options.feeds),
      api_(store, &access_, options.truths),
      // Calls have a quarter as many.
      pool_(4 * options.threads) {}

WebResponse Viewer::AnswerPage(const WebRequest& request) const {
  if (request.path == "/healthz") return Say(200, "ok");
  if (!page_.ok()) return Say(503, page_.status().message());
  return page_->Answer(request);
}

void Viewer::Answer(const WebRequest& request, Respond respond) {
  Respond safely = [respond = std::move(respond)](WebResponse response) {
    AddSafety(response);
    respond(std::move(response));
  };
  if (request.method != "GET" && request.method != "HEAD") {
    WebResponse refusal = Say(405, "a viewer only shows");
    refusal.headers["Allow"] = "GET, HEAD";
    return safely(std::move(refusal));
  }
  if (!absl::StartsWith(request.path, "/api/")) return safely(AnswerPage(request));
  const absl::Status scheduled =
      pool_.ScheduleCall([this, request, safely] { safely(api_.Answer(request)); });
  if (!scheduled.ok()) safely(ToResponse(scheduled));
}

OpenedStream Viewer::Open(const WebRequest& request, std::function<void()> wake) {
  absl::string_view mission = request.path;
  if (!absl::ConsumePrefix(&mission, "/stream/missions/")) {
    return Refuse(absl::NotFoundError("there is no such stream"));
  }
  const std::string name(mission);
  if (const absl::Status named = CheckNameSegment("mission", name); !named.ok()) {
    return Refuse(named);
  }
  if (const absl::Status may = access_.CheckMission(request.token, name); !may.ok()) {
    return Refuse(may);
  }
  absl::StatusOr<std::shared_ptr<MissionFeed>> feed = feeds_.Follow(name);
  if (!feed.ok()) return Refuse(feed.status());
  const auto points = request.query.find("points");
  const bool with_points = points == request.query.end() || points->second != "0";
  return {std::make_unique<FeedStream>(*std::move(feed), with_points, std::move(wake)), 0, ""};
}

}  // namespace corbslam::services
