#include "client/channel.h"

#include <grpcpp/security/credentials.h>
#include <grpcpp/support/client_interceptor.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr size_t kMaxTokenBytes = 256;

absl::StatusOr<std::string> ReadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file.is_open() || file.bad()) {
    return absl::FailedPreconditionError(
        absl::StrCat(path, ": cannot be read: ", std::strerror(errno)));
  }
  return text;
}

absl::StatusOr<std::string> ReadToken(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadText(path));
  std::string token(absl::StripAsciiWhitespace(text));
  // gRPC aborts the process over a header with other characters than these.
  const bool good = !token.empty() && token.size() <= kMaxTokenBytes &&
                    std::all_of(token.begin(), token.end(),
                                [](unsigned char c) { return absl::ascii_isgraph(c); });
  if (!good) return absl::InvalidArgumentError(absl::StrCat(path, ": expected a token, alone"));
  return token;
}

absl::StatusOr<std::string> ReadPem(const std::string& path, const char* what) {
  ASSIGN_OR_RETURN(std::string text, ReadText(path));
  if (!absl::StrContains(text, absl::StrCat(what, "-----"))) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": holds no ", absl::AsciiStrToLower(what), " in PEM format"));
  }
  return text;
}

// Adds "authorization: Bearer TOKEN" to a call.
class TokenInterceptor : public grpc::experimental::Interceptor {
 public:
  explicit TokenInterceptor(std::string token) : token_(std::move(token)) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(
            grpc::experimental::InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      methods->GetSendInitialMetadata()->emplace("authorization", "Bearer " + token_);
    }
    methods->Proceed();
  }

 private:
  const std::string token_;
};

class TokenInterceptorFactory : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  TokenInterceptorFactory(std::string path, std::string token)
      : path_(std::move(path)), token_(std::move(token)) {}

  grpc::experimental::Interceptor* CreateClientInterceptor(
      grpc::experimental::ClientRpcInfo*) override {
    std::lock_guard<std::mutex> lock(mutex_);
    std::error_code error;
    if (std::filesystem::is_regular_file(path_, error)) {  // a pipe gave its token once
      auto read = ReadToken(path_);
      if (read.ok()) token_ = *std::move(read);
    }
    return new TokenInterceptor(token_);
  }

 private:
  const std::string path_;
  std::mutex mutex_;
  std::string token_;
};

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> Credentials(
    const std::string& address, const ClientCredentials& credentials) {
  if (!credentials.wants_tls() || absl::StartsWith(address, "unix")) {
    return grpc::InsecureChannelCredentials();
  }
  grpc::SslCredentialsOptions options;
  if (!credentials.ca_file.empty()) {
    ASSIGN_OR_RETURN(options.pem_root_certs, ReadPem(credentials.ca_file, "CERTIFICATE"));
  }
  if (!credentials.cert_file.empty()) {
    ASSIGN_OR_RETURN(options.pem_cert_chain, ReadPem(credentials.cert_file, "CERTIFICATE"));
    ASSIGN_OR_RETURN(options.pem_private_key, ReadPem(credentials.key_file, "PRIVATE KEY"));
  }
  return grpc::SslCredentials(options);
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::Channel>> OpenChannel(
    const std::string& address, const ClientCredentials& credentials,
    const grpc::ChannelArguments& arguments) {
  RETURN_IF_ERROR(credentials.Check(address));
  ASSIGN_OR_RETURN(const std::shared_ptr<grpc::ChannelCredentials> channel_credentials,
                   Credentials(address, credentials));
  std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> interceptors;
  if (!credentials.token_file.empty()) {
    ASSIGN_OR_RETURN(std::string token, ReadToken(credentials.token_file));
    interceptors.push_back(
        std::make_unique<TokenInterceptorFactory>(credentials.token_file, std::move(token)));
  }
  return grpc::experimental::CreateCustomChannelWithInterceptors(
      address, channel_credentials, arguments, std::move(interceptors));
}

}  // namespace cagefit::client
