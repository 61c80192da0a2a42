// Makes the certificates of deploy/make_test_certificates.sh, for tests.
#ifndef CORBSLAM_SERVICES_SECURITY_TESTING_TEST_CERTIFICATES_H_
#define CORBSLAM_SERVICES_SECURITY_TESTING_TEST_CERTIFICATES_H_

#include <string>
#include <vector>

#include "services/security/security_options.h"

namespace corbslam::test_data {

// Owns a folder of certificates and removes it when it is destroyed.
class TestCertificates {
 public:
  // Makes the certificates of a mission, the servers' also for `hosts` ("10.0.0.5 store.lan"). If
  // that fails the test fails, and the folder is empty.
  explicit TestCertificates(const std::string& mission, const std::string& hosts = "");
  ~TestCertificates();
  TestCertificates(const TestCertificates&) = delete;
  TestCertificates& operator=(const TestCertificates&) = delete;

  std::string Path(const std::string& file) const { return folder_ + "/" + file; }
  // Returns the options of "store", "worker", "alpha", "bravo", "viewer" or "operator".
  services::SecurityOptions Options(const std::string& name) const;
  // Returns the same options as flags.
  std::vector<std::string> Flags(const std::string& name) const;

 private:
  std::string folder_;
};

}  // namespace corbslam::test_data

#endif  // CORBSLAM_SERVICES_SECURITY_TESTING_TEST_CERTIFICATES_H_
