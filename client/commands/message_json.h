// Protocol messages as JSON.
#ifndef CAGEFIT_CLIENT_COMMANDS_MESSAGE_JSON_H_
#define CAGEFIT_CLIENT_COMMANDS_MESSAGE_JSON_H_

#include "cagefit/v1/fitting.pb.h"
#include "client/commands/json.h"

namespace cagefit::client {

// The message's fields by their names in the protocol, those at their default included.
Json ToJson(const google::protobuf::Message& message);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_MESSAGE_JSON_H_
