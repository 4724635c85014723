// One reader per format, from bytes in memory. Errors say what is wrong and where, but not in which
// file. Internal to client/io.
#ifndef CAGEFIT_CLIENT_IO_FORMAT_READERS_H_
#define CAGEFIT_CLIENT_IO_FORMAT_READERS_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/io/geometry_file.h"

namespace cagefit::client {

// Stanford PLY: ascii, binary of both byte orders, any scalar types; elements and properties beside
// vertices (x y z, nx ny nz) and faces (vertex_index or vertex_indices) are skipped.
absl::StatusOr<Geometry> ReadPly(absl::string_view bytes, const ReadLimits& limits);

// Wavefront OBJ: v, vn, f (negative indices too), continued lines; other statements are skipped.
// A vertex takes the mean of its corners' normals when all its corners have one. Comment lines
// "# cagefit crease A B" and "# cagefit corner A" (indices from 1) are tags, added to `tags` where
// it is not null.
absl::StatusOr<Geometry> ReadObj(absl::string_view bytes, const ReadLimits& limits,
                                 CreaseTags* tags);

// OFF, COFF, NOFF, CNOFF, text only, comments allowed.
absl::StatusOr<Geometry> ReadOff(absl::string_view bytes, const ReadLimits& limits);

// STL, binary or text. Corners at the same position become one vertex, in order of appearance.
absl::StatusOr<Geometry> ReadStl(absl::string_view bytes, const ReadLimits& limits);

// A point a line: x y z, then a unit normal where columns 4 to 6 are one in every line; other
// columns are skipped. Blanks, commas or semicolons between numbers; # and // begin comments; a
// first line of column names or of the number of points is skipped.
absl::StatusOr<Geometry> ReadXyz(absl::string_view bytes, const ReadLimits& limits);

// PCD 0.6 and 0.7: ascii, binary, binary_compressed; fields x y z and normal_x normal_y normal_z.
absl::StatusOr<Geometry> ReadPcd(absl::string_view bytes, const ReadLimits& limits);

// Draco, a mesh or a cloud.
absl::StatusOr<Geometry> ReadDrc(absl::string_view bytes, const ReadLimits& limits);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_FORMAT_READERS_H_
