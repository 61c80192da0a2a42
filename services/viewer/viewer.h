// Answers browsers: the page, what it asks about missions, and the streams of live maps.
#ifndef CORBSLAM_SERVICES_VIEWER_VIEWER_H_
#define CORBSLAM_SERVICES_VIEWER_VIEWER_H_

#include <grpcpp/channel.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "services/http/web_message.h"
#include "services/server/task_pool.h"
#include "services/server/work_slots.h"
#include "services/viewer/browser_access.h"
#include "services/viewer/mission_feeds.h"
#include "services/viewer/page_files.h"
#include "services/viewer/refusal_pace.h"
#include "services/viewer/store_api.h"
#include "services/viewer/token_watch.h"
#include "services/viewer/truths.h"

namespace corbslam::services {

struct ViewerOptions {
  MissionFeedsOptions feeds;
  // Threads that wait for the store's answers.
  int threads = 4;
  Truths truths;
  // A channel to the store that brings no token; it is shown those of browsers, and whom it has
  // revoked may not look here either. Null: it is not asked.
  std::shared_ptr<grpc::Channel> token_channel;
  // Connects to other stores, where the store says that they have a mission; null: nobody does.
  ConnectToOther connect = nullptr;
};

// docs/viewer.md says what browsers may ask. Thread-safe.
class Viewer : public WebHandler {
 public:
  // Null `access`: everybody may look at everything. An error instead of a page is what browsers
  // are told.
  Viewer(const std::shared_ptr<grpc::Channel>& store, MissionFeeds::Robots robots,
         std::shared_ptr<const AccessControl> access, absl::StatusOr<PageFiles> page,
         const ViewerOptions& options = {});

  void Answer(const WebRequest& request, Respond respond) override;
  std::string CallerOf(const WebRequest& request) override;
  OpenedStream Open(const WebRequest& request, std::function<void()> wake) override;

  size_t missions() const { return feeds_.missions(); }

 private:
  WebResponse AnswerPage(const WebRequest& request) const;

  // Says whether a browser may look at the mission now.
  absl::Status MayLook(const std::string& token, const std::string& mission);

  const BrowserAccess access_;
  TokenWatch tokens_;
  RefusalPace refusals_;
  WorkSlots answers_;
  const absl::StatusOr<PageFiles> page_;
  const std::shared_ptr<StoreRoutes> routes_;
  MissionFeeds feeds_;
  StoreApi api_;
  // The last member: its tasks use the others.
  TaskPool pool_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_VIEWER_H_
