#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/map_store_service/stored_backup_message.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::PageRequest;

grpc::ServerUnaryReactor* MapStoreService::ListStoredBackups(
    grpc::CallbackServerContext* context, const v1::ListStoredBackupsRequest* request,
    v1::ListStoredBackupsResponse* response) {
  const ListFilter shows = options_.may_list != nullptr ? options_.may_list(*context) : nullptr;
  return AnswerOn(backup_pool_, context, [this, shows, request, response]() -> absl::Status {
    std::string mission;
    if (request->parent() != kAllMissions) {
      ASSIGN_OR_RETURN(mission, ParseMissionName(request->parent()));
    }
    RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
    ASSIGN_OR_RETURN(PageRequest page, ReadPage(*request));
    // As ListMissions: the page is full with what is shown.
    do {
      ASSIGN_OR_RETURN(const auto found, options_.backups->List(mission, page));
      for (const map_store::StoredBackup& backup : found.items) {
        if (shows != nullptr && !shows(backup.mission)) continue;
        ToProto(backup, response->add_backups());
        --page.page_size;
      }
      page.page_token = found.next_page_token;
    } while (page.page_size > 0 && !page.page_token.empty());
    response->set_next_page_token(page.page_token);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
