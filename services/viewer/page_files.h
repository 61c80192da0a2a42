// Keeps the built page's files.
#ifndef CORBSLAM_SERVICES_VIEWER_PAGE_FILES_H_
#define CORBSLAM_SERVICES_VIEWER_PAGE_FILES_H_

#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "services/http/web_message.h"

namespace corbslam::services {

// All files of a folder, read once, so that no request reaches the disk. Immutable, thread-safe.
class PageFiles {
 public:
  // NOT_FOUND: there is no index.html, the page was not built. INVALID_ARGUMENT names a file that
  // is too large to be one of a page, or can't be read.
  static absl::StatusOr<PageFiles> Load(const std::string& folder);

  // Answers a request whose method is GET or HEAD; 404 for what there is not.
  WebResponse Answer(const WebRequest& request) const;

 private:
  struct File {
    std::string content_type;
    std::string tag;  // Of this content: changes with it.
    std::shared_ptr<const std::string> plain;
    std::shared_ptr<const std::string> gzip;  // Null: there is none.
  };

  std::map<std::string, File> files_;  // By the path that is asked for.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_PAGE_FILES_H_
