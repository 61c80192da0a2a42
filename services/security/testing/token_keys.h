// Makes fresh token keys for tests.
#ifndef CORBSLAM_SERVICES_SECURITY_TESTING_TOKEN_KEYS_H_
#define CORBSLAM_SERVICES_SECURITY_TESTING_TOKEN_KEYS_H_

#include <string>

namespace corbslam::test_data {

struct TokenKeys {
  std::string private_pem;
  std::string public_pem;
};

// Makes a pair of keys; `type` is the name that OpenSSL uses.
TokenKeys MakeTokenKeys(const char* type = "ED25519");

}  // namespace corbslam::test_data

#endif  // CORBSLAM_SERVICES_SECURITY_TESTING_TOKEN_KEYS_H_
