#include "services/security/placeholder_pair.h"

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

#include "absl/status/status.h"

namespace corbslam::services {
namespace {

constexpr long kGoodFor_s = 3600;

std::string TextOf(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return size > 0 ? std::string(data, static_cast<size_t>(size)) : "";
}

}  // namespace

absl::StatusOr<KeyPair> MakePlaceholderPair() {
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(EVP_EC_gen("P-256"), EVP_PKEY_free);
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(X509_new(), X509_free);
  const std::unique_ptr<BIO, decltype(&BIO_free)> key_text(BIO_new(BIO_s_mem()), BIO_free);
  const std::unique_ptr<BIO, decltype(&BIO_free)> text(BIO_new(BIO_s_mem()), BIO_free);
  const auto fill = [&] {
    X509* const made = certificate.get();
    X509_NAME* const name = X509_get_subject_name(made);
    const auto* const of_nobody = reinterpret_cast<const unsigned char*>("nobody");
    return X509_set_version(made, 2) == 1 &&
           ASN1_INTEGER_set(X509_get_serialNumber(made), 1) == 1 &&
           X509_gmtime_adj(X509_getm_notBefore(made), 0) != nullptr &&
           X509_gmtime_adj(X509_getm_notAfter(made), kGoodFor_s) != nullptr &&
           X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, of_nobody, -1, -1, 0) == 1 &&
           X509_set_issuer_name(made, name) == 1 && X509_set_pubkey(made, key.get()) == 1 &&
           X509_sign(made, key.get(), EVP_sha256()) > 0;
  };
  const bool good = key != nullptr && certificate != nullptr && key_text != nullptr &&
                    text != nullptr && fill() &&
                    PEM_write_bio_PrivateKey(key_text.get(), key.get(), nullptr, nullptr, 0,
                                             nullptr, nullptr) == 1 &&
                    PEM_write_bio_X509(text.get(), certificate.get()) == 1;
  if (!good) return absl::InternalError("OpenSSL can't make a certificate");
  return KeyPair{TextOf(text.get()), TextOf(key_text.get())};
}

}  // namespace corbslam::services
