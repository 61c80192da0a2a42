#include "services/security/testing/test_certificates.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "absl/strings/str_cat.h"

namespace corbslam::test_data {

using services::SecurityOptions;

TestCertificates::TestCertificates(const std::string& mission, const std::string& hosts)
    : folder_(::testing::TempDir() + "/corbslam_certificates_XXXXXX") {
  EXPECT_NE(mkdtemp(folder_.data()), nullptr) << folder_;
  const std::string command = absl::StrCat(
      "HOSTS='", hosts, "' '" CORBSLAM_CERTIFICATE_SCRIPT "' '", folder_, "' '", mission, "'");
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

TestCertificates::~TestCertificates() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

SecurityOptions TestCertificates::Options(const std::string& name) const {
  SecurityOptions options;
  options.certificate_file = Path(name + ".pem");
  options.key_file = Path(name + ".key");
  options.ca_file = Path("ca.pem");
  return options;
}

std::vector<std::string> TestCertificates::Flags(const std::string& name) const {
  const SecurityOptions options = Options(name);
  return {"--tls-cert", options.certificate_file, "--tls-key", options.key_file,
          "--tls-ca",   options.ca_file};
}

}  // namespace corbslam::test_data
