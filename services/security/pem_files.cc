#include "services/security/pem_files.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kMaxFileBytes = 1 << 20;

using BioPtr = std::unique_ptr<BIO, decltype(&BIO_free)>;
using CertificatePtr = std::unique_ptr<X509, decltype(&X509_free)>;
using KeyPtr = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

BioPtr ReadFrom(const std::string& pem) {
  return {BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free};
}

// Makes OpenSSL refuse a key behind a passphrase; else it would ask for it at the terminal.
int NoPassphrase(char*, int, int, void*) { return -1; }

CertificatePtr ParseCertificate(const std::string& pem) {
  const BioPtr bio = ReadFrom(pem);
  CertificatePtr certificate(PEM_read_bio_X509(bio.get(), nullptr, NoPassphrase, nullptr),
                             X509_free);
  ERR_clear_error();
  return certificate;
}

KeyPtr ParseKey(const std::string& pem) {
  const BioPtr bio = ReadFrom(pem);
  KeyPtr key(PEM_read_bio_PrivateKey(bio.get(), nullptr, NoPassphrase, nullptr), EVP_PKEY_free);
  ERR_clear_error();
  return key;
}

absl::Status Bad(absl::string_view flag, const std::string& path, absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat(flag, " ", path, " ", why));
}

}  // namespace

absl::StatusOr<std::string> ReadSecurityFile(absl::string_view flag, const std::string& path) {
  absl::StatusOr<std::string> text = ReadListFile(flag, path);
  if (text.ok() && text->empty()) return Bad(flag, path, "can't be read or is empty");
  return text;
}

absl::StatusOr<std::string> ReadListFile(absl::string_view flag, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxFileBytes + 1, '\0');
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size())) && !file.eof()) {
    return Bad(flag, path, "can't be read");
  }
  text.resize(static_cast<size_t>(file.gcount()));
  if (text.size() > kMaxFileBytes) return Bad(flag, path, "is longer than 1 MiB");
  return text;
}

absl::StatusOr<KeyPair> ReadKeyPair(const std::string& certificate_path,
                                    const std::string& key_path, absl::string_view certificate_flag,
                                    absl::string_view key_flag) {
  KeyPair pair;
  ASSIGN_OR_RETURN(pair.certificate_pem, ReadSecurityFile(certificate_flag, certificate_path));
  ASSIGN_OR_RETURN(pair.key_pem, ReadSecurityFile(key_flag, key_path));
  const CertificatePtr certificate = ParseCertificate(pair.certificate_pem);
  if (certificate == nullptr)
    return Bad(certificate_flag, certificate_path, "holds no certificate");
  const KeyPtr key = ParseKey(pair.key_pem);
  if (key == nullptr) {
    return Bad(key_flag, key_path, "holds no private key that needs no passphrase");
  }
  const bool match = X509_check_private_key(certificate.get(), key.get()) == 1;
  ERR_clear_error();
  if (!match) {
    return Bad(key_flag, key_path, absl::StrCat("does not belong to ", certificate_path));
  }
  if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) <= 0) {
    return Bad(certificate_flag, certificate_path, "has expired");
  }
  return pair;
}

absl::StatusOr<std::string> ReadAuthorities(const std::string& path) {
  ASSIGN_OR_RETURN(std::string pem, ReadSecurityFile("--tls-ca", path));
  if (ParseCertificate(pem) != nullptr) return pem;
  return Bad("--tls-ca", path, "holds no certificate");
}

absl::Time FirstExpiry(const std::string& certificates_pem) {
  const BioPtr bio = ReadFrom(certificates_pem);
  absl::Time first = absl::InfiniteFuture();
  while (true) {
    const CertificatePtr certificate(PEM_read_bio_X509(bio.get(), nullptr, NoPassphrase, nullptr),
                                     X509_free);
    if (certificate == nullptr) break;
    std::tm parts = {};
    if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &parts) != 1) continue;
    first = std::min(first, absl::FromTM(parts, absl::UTCTimeZone()));
  }
  ERR_clear_error();
  return first;
}

}  // namespace corbslam::services
