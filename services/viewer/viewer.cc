#include "services/viewer/viewer.h"

#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Close codes of a WebSocket, as the page knows them.
constexpr uint16_t kUnauthenticated = 4401;
constexpr uint16_t kForbidden = 4403;
constexpr uint16_t kNotFound = 4404;
constexpr uint16_t kBusy = 4429;

// Questions that are answered, or wait for that, at one time: in all, and of one host.
constexpr size_t kMaxAnswers = 128;
constexpr size_t kMaxAnswersOfHost = 32;

// What browsers are told of each answer: the page's own scripts and styles alone count, nobody puts
// it into a frame, and nothing is guessed.
void AddSafety(WebResponse& response) {
  response.headers["Content-Security-Policy"] =
      "default-src 'self'; img-src 'self' data:; connect-src 'self' ws: wss:; object-src 'none'; "
      "base-uri 'none'; frame-ancestors 'none'; form-action 'none'";
  response.headers["X-Content-Type-Options"] = "nosniff";
  response.headers["Referrer-Policy"] = "no-referrer";
}

uint16_t CloseCodeOf(const absl::Status& status) {
  if (absl::IsUnauthenticated(status)) return kUnauthenticated;
  if (absl::IsPermissionDenied(status)) return kForbidden;
  return absl::IsResourceExhausted(status) ? kBusy : kNotFound;
}

// Tells one browser what its mission's feed has.
class FeedStream : public WebStream {
 public:
  using MayLook = std::function<absl::Status()>;

  FeedStream(std::shared_ptr<MissionFeed> feed, bool with_points, std::function<void()> wake,
             MayLook may_look)
      : feed_(std::move(feed)),
        may_look_(std::move(may_look)),
        token_(feed_->AddListener(std::move(wake))) {
    reader_.with_points = with_points;
  }
  ~FeedStream() override { feed_->RemoveListener(token_); }

  std::shared_ptr<const std::string> Next() override { return feed_->Next(reader_); }
  CloseReason WhyClose() override {
    const absl::Status may_look = may_look_();
    if (may_look.ok()) return {};
    return {CloseCodeOf(may_look), std::string(may_look.message())};
  }

 private:
  const std::shared_ptr<MissionFeed> feed_;
  const MayLook may_look_;
  const uint64_t token_;
  FeedReader reader_;
};

OpenedStream Refuse(const absl::Status& status) {
  OpenedStream refused;
  refused.close_code = CloseCodeOf(status);
  refused.reason = std::string(status.message());
  return refused;
}

// Returns true if somebody was refused for the token that was shown, or for none.
bool IsOfToken(const absl::Status& status) {
  return absl::IsUnauthenticated(status) || absl::IsPermissionDenied(status);
}

}  // namespace

Viewer::Viewer(const std::shared_ptr<grpc::Channel>& store, MissionFeeds::Robots robots,
               std::shared_ptr<const AccessControl> access, absl::StatusOr<PageFiles> page,
               const ViewerOptions& options)
    : access_(std::move(access)),
      tokens_(options.token_channel),
      answers_({.what = "questions",
                .all = kMaxAnswers,
                .of_caller = kMaxAnswersOfHost,
                .of_resource = kMaxAnswers}),
      page_(std::move(page)),
      routes_(std::make_shared<StoreRoutes>(store, options.connect)),
      feeds_(routes_, std::move(robots), options.feeds),
      api_(
          routes_, &access_,
          [this](const std::string& token, const std::string& mission) {
            return tokens_.AskAndCheck(access_.TokenId(token), token, mission);
          },
          options.truths),
      // Calls have a quarter as many.
      pool_(4 * options.threads) {}

WebResponse Viewer::AnswerPage(const WebRequest& request) const {
  if (request.path == "/healthz") return TextResponse(200, "ok");
  if (!page_.ok()) return TextResponse(503, page_.status().message());
  return page_->Answer(request);
}

void Viewer::Answer(const WebRequest& request, Respond respond) {
  Respond safely = [respond = std::move(respond)](WebResponse response) {
    AddSafety(response);
    respond(std::move(response));
  };
  if (request.method != "GET" && request.method != "HEAD") {
    WebResponse refusal = TextResponse(405, "a viewer only shows");
    refusal.headers["Allow"] = "GET, HEAD";
    return safely(std::move(refusal));
  }
  if (!absl::StartsWith(request.path, "/api/")) return safely(AnswerPage(request));
  absl::StatusOr<std::shared_ptr<const void>> slot = answers_.Enter(request.host, "");
  absl::Status scheduled = slot.status();
  if (slot.ok()) {
    scheduled = pool_.ScheduleCall([this, request, safely, slot = *std::move(slot)] {
      WebResponse response = api_.Answer(request);
      if (response.status == 401 || response.status == 403) {
        response.delay = refusals_.Note(request.host, absl::Now());
      }
      safely(std::move(response));
    });
  }
  if (!scheduled.ok()) safely(ToResponse(scheduled));
}

absl::Status Viewer::MayLook(const std::string& token, const std::string& mission) {
  RETURN_IF_ERROR(access_.CheckMission(token, mission));
  return tokens_.Check(access_.TokenId(token), token, mission);
}

std::string Viewer::CallerOf(const WebRequest& request) {
  const std::string id = access_.TokenId(request.token);
  return id.empty() ? "" : absl::StrCat("the token ", id);
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
  if (const absl::Status may = MayLook(request.token, name); !may.ok()) {
    OpenedStream refused = Refuse(may);
    if (IsOfToken(may)) refused.delay = refusals_.Note(request.host, absl::Now());
    return refused;
  }
  absl::StatusOr<std::shared_ptr<MissionFeed>> feed = feeds_.Follow(name);
  if (!feed.ok()) return Refuse(feed.status());
  const auto points = request.query.find("points");
  const bool with_points = points == request.query.end() || points->second != "0";
  OpenedStream opened;
  opened.stream = std::make_unique<FeedStream>(
      *std::move(feed), with_points, std::move(wake),
      [this, token = request.token, name] { return MayLook(token, name); });
  return opened;
}

}  // namespace corbslam::services
