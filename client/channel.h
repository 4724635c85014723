// A gRPC channel with a client's credentials.
#ifndef CAGEFIT_CLIENT_CHANNEL_H_
#define CAGEFIT_CLIENT_CHANNEL_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/credentials.h"

namespace cagefit::client {

// Connects lazily. The token's file is read again for every call, so a new token needs no new
// channel; while it cannot be read, the last one is used. INVALID_ARGUMENT as of
// ClientCredentials::Check, and naming a file that does not hold what it should;
// FAILED_PRECONDITION naming one that cannot be read.
absl::StatusOr<std::shared_ptr<grpc::Channel>> OpenChannel(const std::string& address,
                                                           const ClientCredentials& credentials,
                                                           const grpc::ChannelArguments& arguments);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_CHANNEL_H_
