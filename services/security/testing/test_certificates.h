// The certificates of deploy/make_test_certificates.sh, for tests.
#ifndef CORBSLAM_SERVICES_SECURITY_TESTING_TEST_CERTIFICATES_H_
#define CORBSLAM_SERVICES_SECURITY_TESTING_TEST_CERTIFICATES_H_

#include <string>
#include <vector>

#include "services/security/security_options.h"

namespace corbslam::test_data {

// Removed with the object.
class TestCertificates {
 public:
  // Those of a mission, the servers' also for `hosts` ("10.0.0.5 store.lan"). A failure is a
  // failure of the test, and then the folder is empty.
  explicit TestCertificates(const std::string& mission, const std::string& hosts = "");
  ~TestCertificates();
  TestCertificates(const TestCertificates&) = delete;
  TestCertificates& operator=(const TestCertificates&) = delete;

  std::string Path(const std::string& file) const { return folder_ + "/" + file; }
  // Of "store", "worker", "alpha", "bravo", "viewer" or "operator".
  SecurityOptions Options(const std::string& name) const;
  // The same as flags.
  std::vector<std::string> Flags(const std::string& name) const;

 private:
  std::string folder_;
};

}  // namespace corbslam::test_data

#endif  // CORBSLAM_SERVICES_SECURITY_TESTING_TEST_CERTIFICATES_H_
