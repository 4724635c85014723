// The numbers of a report page, as text that no file name and no message can break out of.
//
// base64 [rfc4648] of a zlib stream [rfc1950] of
//   4 bytes      length of the header, little-endian
//   the header   JSON; its "arrays" lists {"name", "width", "count", "stride"} of what follows
//   the arrays   one after the other, each as `width` planes of `count` bytes: the lowest byte of
//                every value, then the next ...
// With a stride s > 0 the values from the s-th on are differences to those s places before, modulo
// 2^(8 width): what moves little, or repeats, is then small.
#ifndef CAGEFIT_CLIENT_REPORT_PAYLOAD_H_
#define CAGEFIT_CLIENT_REPORT_PAYLOAD_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cagefit::client {

class Payload {
 public:
  // `width`: bytes of a value, 1 to 4; higher bytes are dropped.
  void Add(const std::string& name, int width, size_t stride, const std::vector<uint32_t>& values);

  // The text. Invalid UTF-8 in `header` becomes U+FFFD.
  std::string Encode(nlohmann::ordered_json header) const;

 private:
  nlohmann::ordered_json arrays_ = nlohmann::ordered_json::array();
  std::string planes_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_PAYLOAD_H_
