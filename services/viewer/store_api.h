// Asks the map store what a page asks about a mission, and puts the answers into JSON.
#ifndef CORBSLAM_SERVICES_VIEWER_STORE_API_H_
#define CORBSLAM_SERVICES_VIEWER_STORE_API_H_

#include <grpcpp/channel.h>

#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/viewer/browser_access.h"
#include "services/viewer/truths.h"
#include "services/viewer/web/web_message.h"

namespace corbslam::services {

// Puts an error into the answer: 400, 401, 403, 404, 429, 502 or 503, and {"error": words}.
WebResponse ToResponse(const absl::Status& error);

// Answers requests for /api/..., which only read (docs/viewer.md). Each call blocks as
// long as the store takes, a minute at most. Thread-safe.
class StoreApi {
 public:
  // `access` is not owned and must outlive it.
  StoreApi(const std::shared_ptr<grpc::Channel>& store, const BrowserAccess* access, Truths truths)
      : store_(v1::MapStore::NewStub(store)), access_(*access), truths_(std::move(truths)) {}

  WebResponse Answer(const WebRequest& request);

 private:
  using Answered = absl::StatusOr<WebResponse>;

  Answered AnswerOrError(const WebRequest& request);
  Answered ListMissions(const WebRequest& request);
  // `rest` is what follows the mission in the path.
  Answered OfMission(const std::string& mission, const std::vector<std::string>& rest,
                     const WebRequest& request);
  Answered GetMission(const std::string& mission);
  Answered ListAgents(const std::string& mission, const WebRequest& request);
  Answered ListLocalMaps(const std::string& mission, const WebRequest& request);
  Answered ListOverlaps(const std::string& mission, const WebRequest& request);
  Answered GetKeyframe(const std::string& name, const WebRequest& request);
  Answered GetPicture(const std::string& name);
  Answered GetOverlap(const std::string& name);
  Answered GetTrajectory(const std::string& mission, const WebRequest& request);
  Answered GetHistory(const std::string& mission, const WebRequest& request);
  Answered GetTruth(const std::string& mission) const;

  const std::unique_ptr<v1::MapStore::Stub> store_;
  const BrowserAccess& access_;
  const Truths truths_;
  // An answer of many megabytes is put together for one request at a time.
  std::atomic<bool> replaying_ = false;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_STORE_API_H_
