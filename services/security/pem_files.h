// Reads certificates and keys, and finds out what is wrong with them before a handshake does.
#ifndef CORBSLAM_SERVICES_SECURITY_PEM_FILES_H_
#define CORBSLAM_SERVICES_SECURITY_PEM_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Reads a file of at most 1 MiB. INVALID_ARGUMENT names the flag and the file.
absl::StatusOr<std::string> ReadSecurityFile(absl::string_view flag, const std::string& path);
// Reads it likewise; it may be empty.
absl::StatusOr<std::string> ReadListFile(absl::string_view flag, const std::string& path);

struct KeyPair {
  std::string certificate_pem;
  std::string key_pem;
};
// Reads a certificate and the key that belongs to it; errors name the flags as they are given here.
absl::StatusOr<KeyPair> ReadKeyPair(const std::string& certificate_path,
                                    const std::string& key_path,
                                    absl::string_view certificate_flag = "--tls-cert",
                                    absl::string_view key_flag = "--tls-key");
// Reads one or more certificates.
absl::StatusOr<std::string> ReadAuthorities(const std::string& path);

// Returns when the first of the certificates in the text expires; InfiniteFuture if there is none.
absl::Time FirstExpiry(const std::string& certificates_pem);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_PEM_FILES_H_
