#include "services/security/testing/token_keys.h"

#include <openssl/evp.h>
#include <openssl/pem.h>

#include <memory>

namespace corbslam::test_data {
namespace {

using BioPtr = std::unique_ptr<BIO, decltype(&BIO_free)>;

std::string ToText(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<size_t>(size)};
}

}  // namespace

TokenKeys MakeTokenKeys(const char* type) {
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      EVP_PKEY_Q_keygen(nullptr, nullptr, type), EVP_PKEY_free);
  const BioPtr private_pem(BIO_new(BIO_s_mem()), BIO_free);
  const BioPtr public_pem(BIO_new(BIO_s_mem()), BIO_free);
  PEM_write_bio_PrivateKey(private_pem.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  PEM_write_bio_PUBKEY(public_pem.get(), key.get());
  return {ToText(private_pem.get()), ToText(public_pem.get())};
}

}  // namespace corbslam::test_data
