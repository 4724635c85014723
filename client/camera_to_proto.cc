#include "client/camera_to_proto.h"

namespace cagefit::client {

v1::Camera ToProto(const Camera& camera) {
  v1::Camera proto;
  proto.set_name(camera.name);
  proto.set_width(camera.width);
  proto.set_height(camera.height);
  proto.set_fx(camera.fx);
  proto.set_fy(camera.fy);
  proto.set_cx(camera.cx);
  proto.set_cy(camera.cy);
  for (int k = 0; k < 9; ++k) proto.add_rotation(camera.R(k / 3, k % 3));
  for (int k = 0; k < 3; ++k) proto.add_translation(camera.t[k]);
  proto.set_k1(camera.distortion.k1);
  proto.set_k2(camera.distortion.k2);
  proto.set_p1(camera.distortion.p1);
  proto.set_p2(camera.distortion.p2);
  proto.set_k3(camera.distortion.k3);
  return proto;
}

}  // namespace cagefit::client
