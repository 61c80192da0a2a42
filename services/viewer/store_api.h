// Asks the map store what a page asks about a mission, and puts the answers into JSON.
#ifndef CORBSLAM_SERVICES_VIEWER_STORE_API_H_
#define CORBSLAM_SERVICES_VIEWER_STORE_API_H_

#include <grpcpp/channel.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/remote/store_route.h"
#include "services/http/web_message.h"
#include "services/server/work_slots.h"
#include "services/viewer/answer_memory.h"
#include "services/viewer/browser_access.h"
#include "services/viewer/truths.h"

namespace corbslam::services {

// Puts an error into the answer: 400, 401, 403, 404, 429, 502 or 503, and {"error": words}.
WebResponse ToResponse(const absl::Status& error);

// Answers requests for /api/..., which only read (docs/viewer.md). Each call blocks as
// long as the store takes, a minute at most. Thread-safe.
class StoreApi {
 public:
  // Returns why a token that `access` takes may not look at the mission after all; OK: it may.
  using AskStore =
      std::function<absl::Status(const std::string& token, const std::string& mission)>;

  // `access` is not owned and must outlive it; `ask_store` may be null.
  StoreApi(std::shared_ptr<StoreRoutes> routes, const BrowserAccess* access, AskStore ask_store,
           Truths truths)
      : routes_(std::move(routes)),
        access_(*access),
        ask_store_(std::move(ask_store)),
        truths_(std::move(truths)) {}

  WebResponse Answer(const WebRequest& request);

 private:
  static constexpr size_t kMaxReplays = 4;
  // All answers of many megabytes together have at most so many bytes, those being sent included.
  static constexpr size_t kMaxAnswerBytes = size_t{256} << 20;

  using Answered = absl::StatusOr<WebResponse>;
  using Store = v1::MapStore::Stub;

  Answered AnswerOrError(const WebRequest& request);
  Answered ListMissions(const WebRequest& request);
  // `rest` is what follows the mission in the path. Asks the store that has the mission.
  Answered OfMission(const std::string& mission, const std::vector<std::string>& rest,
                     const WebRequest& request);
  Answered AskOne(Store& store, const std::string& mission, const std::vector<std::string>& rest,
                  const WebRequest& request);
  Answered GetMission(Store& store, const std::string& mission);
  Answered ListAgents(Store& store, const std::string& mission, const WebRequest& request);
  Answered ListLocalMaps(Store& store, const std::string& mission, const WebRequest& request);
  Answered ListOverlaps(Store& store, const std::string& mission, const WebRequest& request);
  Answered GetKeyframe(Store& store, const std::string& name, const WebRequest& request);
  Answered GetPicture(Store& store, const std::string& name);
  Answered GetOverlap(Store& store, const std::string& name);
  Answered GetTrajectory(Store& store, const std::string& mission, const WebRequest& request);
  Answered GetHistory(Store& store, const std::string& mission, const WebRequest& request);
  Answered GetTruth(const std::string& mission) const;

  const std::shared_ptr<StoreRoutes> routes_;
  const BrowserAccess& access_;
  const AskStore ask_store_;
  const Truths truths_;
  // A mission's past is told to one page at a time, those of few missions at once.
  WorkSlots replays_{{.what = "pages that are told its past",
                      .all = kMaxReplays,
                      .of_caller = kMaxReplays,
                      .of_resource = 1}};
  AnswerMemory memory_{kMaxAnswerBytes};
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_STORE_API_H_
