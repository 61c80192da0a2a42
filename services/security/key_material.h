// Hands certificates and keys to gRPC in a way that lets them be replaced while it runs.
#ifndef CORBSLAM_SERVICES_SECURITY_KEY_MATERIAL_H_
#define CORBSLAM_SERVICES_SECURITY_KEY_MATERIAL_H_

#include <grpcpp/security/tls_certificate_provider.h>

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

// Holds text in memory under a path of this process. Not thread-safe, but whoever reads the path
// meanwhile gets the old text or the new one, never some of both; its modification time moves by a
// second at least whenever the text is replaced.
class MemoryFile {
 public:
  MemoryFile() = default;
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  // RESOURCE_EXHAUSTED where the system gives no memory or no file, and then the old text stays.
  absl::Status Replace(absl::string_view text);
  // Returns the path; empty before the first Replace.
  std::string path() const;

 private:
  int file_ = -1;
  int64_t modified_s_ = 0;
};

// Has gRPC look at what was checked before, and not at the files that people write: gRPC would drop
// a good certificate when a bad one takes its place. Not thread-safe.
class KeyMaterial {
 public:
  // Replaces the certificate with its key (one after the other, as PEM), or the authorities. New
  // connections use them from the next second on; those that stand are left alone.
  absl::Status SetPair(absl::string_view key_and_certificate_pem);
  absl::Status SetAuthorities(absl::string_view pem);

  bool has_pair() const { return !pair_.path().empty(); }
  bool has_authorities() const { return !authorities_.path().empty(); }
  // Makes what gRPC asks for credentials; the first pair and authorities are set before. The key
  // material must outlive all that holds it.
  std::shared_ptr<grpc::experimental::CertificateProviderInterface> MakeProvider() const;

 private:
  MemoryFile pair_;
  MemoryFile authorities_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_KEY_MATERIAL_H_
