// SPDX-License-Identifier: BSD-3-Clause
#include "Sha256.h"

#include <openssl/evp.h>

#include <fstream>
#include <memory>
#include <vector>

namespace slalom::app
{
namespace
{
class Digest
{
 public:
  Digest() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free)
  {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  void add(const char* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
  [[nodiscard]] std::string hex()
  {
    unsigned char bytes[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), bytes, &size);
    std::string text;
    constexpr char kDigits[] = "0123456789abcdef";
    for (unsigned int i = 0; i < size; ++i)
    {
      text += kDigits[bytes[i] / 16];
      text += kDigits[bytes[i] % 16];
    }
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string sha256OfText(std::string_view text)
{
  Digest digest;
  digest.add(text.data(), text.size());
  return digest.hex();
}

std::string sha256OfFile(const std::filesystem::path& file)
{
  std::ifstream in(file, std::ios::binary);
  if (!in) return {};
  Digest digest;
  std::vector<char> block(1 << 20);
  while (in.read(block.data(), std::streamsize(block.size())) || in.gcount() > 0)
    digest.add(block.data(), std::size_t(in.gcount()));
  return digest.hex();
}

}  // namespace slalom::app
