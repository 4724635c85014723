#include "server/session/digest.h"

#include <openssl/evp.h>
#include <openssl/rand.h>

#include <cstdlib>

#include "absl/strings/escaping.h"

namespace cagefit::server {

Digest Sha256(absl::string_view bytes) {
  Digest digest;
  // Fails only when OpenSSL itself cannot run; going on without digests would break exactly-once.
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1) {
    std::abort();
  }
  return digest;
}

std::string RandomId() {
  unsigned char random[16];
  if (RAND_bytes(random, sizeof(random)) != 1) std::abort();  // no entropy: no safe identifier
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(random), sizeof(random)));
}

}  // namespace cagefit::server
