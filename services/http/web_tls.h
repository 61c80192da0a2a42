// Holds the key pair that a web server's next connections go by.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_TLS_H_
#define CORBSLAM_SERVICES_HTTP_WEB_TLS_H_

#include <boost/asio/ssl/context.hpp>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::services {

// TLS 1.2 and newer, with a key pair that may be replaced. Thread-safe.
class WebTls {
 public:
  // INVALID_ARGUMENT if the key pair can't be used.
  static absl::StatusOr<std::unique_ptr<WebTls>> Make(const std::string& certificate_pem,
                                                      const std::string& key_pem);

  // Connections that are made from now on go by this pair; those that stand keep theirs.
  // INVALID_ARGUMENT if it can't be used, and then the one before stays.
  absl::Status Replace(const std::string& certificate_pem, const std::string& key_pem)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Never null.
  std::shared_ptr<boost::asio::ssl::context> context() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  explicit WebTls(std::shared_ptr<boost::asio::ssl::context> context)
      : context_(std::move(context)) {}

  mutable absl::Mutex mutex_;
  std::shared_ptr<boost::asio::ssl::context> context_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_TLS_H_
