// Cameras as the protocol has them.
#ifndef CAGEFIT_CLIENT_CAMERA_TO_PROTO_H_
#define CAGEFIT_CLIENT_CAMERA_TO_PROTO_H_

#include "cagefit/v1/fitting.pb.h"
#include "core/image/camera.h"

namespace cagefit::client {

v1::Camera ToProto(const Camera& camera);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_CAMERA_TO_PROTO_H_
