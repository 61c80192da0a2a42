#include "services/security/certificate_checks.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509_vfy.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <ctime>
#include <memory>
#include <vector>

#include "services/security/pem_files.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kSoon = absl::Hours(14 * 24);

using CertificatePtr = std::unique_ptr<X509, decltype(&X509_free)>;

std::vector<CertificatePtr> ParseAll(const std::string& pem) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> bio(
      BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free);
  std::vector<CertificatePtr> certificates;
  while (true) {
    CertificatePtr certificate(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr), X509_free);
    if (certificate == nullptr) break;
    certificates.push_back(std::move(certificate));
  }
  ERR_clear_error();
  return certificates;
}

Finding NoCertificate(const std::string& check) {
  return {Level::kFail, check, "holds no certificate", "give it one as PEM (docs/security.md)"};
}

absl::Time ToTime(const ASN1_TIME* time) {
  std::tm parts = {};
  ASN1_TIME_to_tm(time, &parts);
  return absl::FromTM(parts, absl::UTCTimeZone());
}

std::string Day(absl::Time time) {
  return absl::FormatTime("%Y-%m-%d %H:%M", time, absl::UTCTimeZone());
}

bool IsFor(X509* certificate, const std::string& host) {
  return X509_check_host(certificate, host.data(), host.size(), 0, nullptr) == 1 ||
         X509_check_ip_asc(certificate, host.c_str(), 0) == 1;
}

// Returns what OpenSSL says against the chain; empty if nothing.
std::string VerifyChain(const std::vector<CertificatePtr>& chain,
                        const std::vector<CertificatePtr>& authorities) {
  const std::unique_ptr<X509_STORE, decltype(&X509_STORE_free)> store(X509_STORE_new(),
                                                                      X509_STORE_free);
  for (const CertificatePtr& authority : authorities) {
    X509_STORE_add_cert(store.get(), authority.get());
  }
  const std::unique_ptr<STACK_OF(X509), void (*)(STACK_OF(X509)*)> between(
      sk_X509_new_null(), [](STACK_OF(X509) * stack) { sk_X509_free(stack); });
  for (size_t i = 1; i < chain.size(); ++i) sk_X509_push(between.get(), chain[i].get());
  const std::unique_ptr<X509_STORE_CTX, decltype(&X509_STORE_CTX_free)> context(
      X509_STORE_CTX_new(), X509_STORE_CTX_free);
  X509_STORE_CTX_init(context.get(), store.get(), chain[0].get(), between.get());
  // Expiry is not checked here: CheckExpiry does that.
  X509_VERIFY_PARAM_set_flags(X509_STORE_CTX_get0_param(context.get()), X509_V_FLAG_NO_CHECK_TIME);
  const bool good = X509_verify_cert(context.get()) == 1;
  ERR_clear_error();
  return good ? "" : X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get()));
}

}  // namespace

Finding CheckExpiry(const std::string& check, const std::string& pem, absl::Time now) {
  const std::vector<CertificatePtr> certificates = ParseAll(pem);
  if (certificates.empty()) return NoCertificate(check);
  absl::Time begin = absl::InfinitePast();
  absl::Time end = absl::InfiniteFuture();
  for (const CertificatePtr& certificate : certificates) {
    begin = std::max(begin, ToTime(X509_get0_notBefore(certificate.get())));
    end = std::min(end, ToTime(X509_get0_notAfter(certificate.get())));
  }
  if (now < begin) {
    return {Level::kFail, check, "is good from " + Day(begin) + " on only", "set the clock"};
  }
  if (now > end) return {Level::kFail, check, "expired at " + Day(end), "get a new one"};
  if (end - now < kSoon) {
    return {Level::kWarn, check, "expires at " + Day(end),
            "get a new one; programs take it without a restart"};
  }
  return {Level::kOk, check, "good until " + Day(end), ""};
}

Finding CheckChain(const std::string& check, const std::string& pem,
                   const std::string& authorities_pem) {
  const std::vector<CertificatePtr> chain = ParseAll(pem);
  if (chain.empty()) return NoCertificate(check);
  const std::string error = VerifyChain(chain, ParseAll(authorities_pem));
  if (error.empty()) return {Level::kOk, check, "issued by an authority of --tls-ca", ""};
  return {Level::kFail, check, "does not lead to an authority of --tls-ca: " + error,
          "name the authority that issued it, and put those between into the certificate's file"};
}

Finding CheckHost(const std::string& check, const std::string& pem, const std::string& host) {
  const std::vector<CertificatePtr> certificates = ParseAll(pem);
  if (certificates.empty()) return NoCertificate(check);
  if (IsFor(certificates[0].get(), host)) return {Level::kOk, check, "is for " + host, ""};
  return {Level::kFail, check, "is not for " + host,
          "use an address that it names, or issue it for this host, too"};
}

Findings CheckSecurityFiles(const SecurityOptions& options, absl::Time now) {
  if (options.insecure) {
    return {{Level::kWarn, "TLS", "left out by --insecure", "on loopback only (docs/security.md)"}};
  }
  Findings findings;
  const auto fail = [&](const char* check, const absl::Status& status) {
    findings.push_back(
        {Level::kFail, check, std::string(status.message()), "docs/security.md says what it is"});
  };
  std::string authorities;
  if (!options.ca_file.empty()) {
    const auto pem = ReadAuthorities(options.ca_file);
    if (pem.ok()) {
      authorities = *pem;
      findings.push_back(CheckExpiry("--tls-ca", *pem, now));
    } else {
      fail("--tls-ca", pem.status());
    }
  }
  if (!options.certificate_file.empty() || !options.key_file.empty()) {
    const auto certificate = ReadSecurityFile("--tls-cert", options.certificate_file);
    if (certificate.ok()) findings.push_back(CheckExpiry("--tls-cert", *certificate, now));
    const auto pair = ReadKeyPair(options.certificate_file, options.key_file);
    if (!pair.ok()) fail("--tls-key", pair.status());
    if (certificate.ok() && !authorities.empty()) {
      findings.push_back(CheckChain("--tls-cert", *certificate, authorities));
    }
  }
  if (!options.token_file.empty()) {
    const auto token = ReadSecurityFile("--token-file", options.token_file);
    if (!token.ok()) fail("--token-file", token.status());
  }
  return findings;
}

}  // namespace corbslam::services
