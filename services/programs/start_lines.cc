#include "services/programs/start_lines.h"

#include "absl/strings/str_cat.h"

namespace corbslam::services {

std::string DescribeServing(const SecurityOptions& security) {
  if (security.insecure) return "without TLS, to everybody";
  if (security.token_key_file.empty()) return "with TLS, to certificates";
  return security.ca_file.empty() ? "with TLS, to tokens" : "with TLS, to certificates and tokens";
}

std::string DescribeCalling(const SecurityOptions& security) {
  if (security.insecure) return "without TLS";
  std::string text = "with TLS";
  if (!security.certificate_file.empty()) {
    absl::StrAppend(&text, ", by certificate ", security.certificate_file);
  }
  if (!security.token_file.empty()) {
    absl::StrAppend(&text, ", by the token in ", security.token_file);
  }
  return text;
}

}  // namespace corbslam::services
