// Reads the certificate that browsers are shown, and reads it again while a viewer runs.
#ifndef CORBSLAM_SERVICES_VIEWER_WEB_CERTIFICATE_H_
#define CORBSLAM_SERVICES_VIEWER_WEB_CERTIFICATE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/http/web_tls.h"
#include "services/security/credential_watch.h"

namespace corbslam::services {

// Reads the PEM files of --web-cert and --web-key, and looks at them at each interval for as long
// as the result lives: a pair that can be used is what new connections get, and one that can't is
// said in the log with its file, and the one before stays. INVALID_ARGUMENT names flag and file.
absl::StatusOr<std::shared_ptr<const WebTls>> WatchWebCertificate(
    const std::string& certificate_path, const std::string& key_path,
    absl::Duration interval = CredentialWatch::kInterval);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_WEB_CERTIFICATE_H_
