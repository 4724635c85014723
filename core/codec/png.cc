#include "core/codec/png.h"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>
#include <type_traits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/codec/mask_channel.h"

namespace cagefit {
namespace {

// No deflated stream holds more bytes for each of its own.
constexpr int64_t kMostInflation = 1032;

// libpng leaves a call that fails by longjmp, which runs no destructors. So `step` has no local
// that needs one; what it writes to belongs to the caller. A compiler never inlines what calls
// setjmp: the caller's own locals keep their values.
template <typename Step>
bool Guarded(png_structp png, Step step) {
  static_assert(std::is_trivially_destructible_v<Step>);
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  step();
  return true;
}

struct ErrorText {
  char text[160] = "";
};

[[noreturn]] void OnError(png_structp png, png_const_charp message) {
  auto* error = static_cast<ErrorText*>(png_get_error_ptr(png));
  std::snprintf(error->text, sizeof(error->text), "%s", message);
  png_longjmp(png, 1);
}

void OnWarning(png_structp, png_const_charp) {}

void TakeBytes(png_structp png, png_bytep out, size_t size) {
  auto* rest = static_cast<absl::string_view*>(png_get_io_ptr(png));
  if (rest->size() < size) png_error(png, "the bytes end early");
  std::memcpy(out, rest->data(), size);
  rest->remove_prefix(size);
}

class PngReader {
 public:
  explicit PngReader(absl::string_view bytes)
      : rest_(bytes),
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &error_, OnError, OnWarning)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {}
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  absl::Status ReadHeader() {
    if (info_ == nullptr) return absl::ResourceExhaustedError("PNG: there is no memory left");
    const bool done = Guarded(png_, [this] {
      png_set_read_fn(png_, &rest_, TakeBytes);
      // Text, profiles and the like are neither needed nor given memory; palette and tRNS are.
      png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
      // Above libpng's own limits ours would not be named.
      png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
      png_read_info(png_, info_);
    });
    return done ? absl::OkStatus() : Error();
  }

  int64_t width() const { return png_get_image_width(png_, info_); }
  int64_t height() const { return png_get_image_height(png_, info_); }
  int bits_per_pixel() const {
    return png_get_channels(png_, info_) * png_get_bit_depth(png_, info_);
  }

  // Requires ReadHeader.
  absl::StatusOr<PixelSamples> ReadPixels() {
    if (!Guarded(png_, [this] { AskForWholeBytes(); })) return Error();
    PixelSamples samples;
    samples.width = static_cast<int>(width());
    samples.height = static_cast<int>(height());
    samples.channels = png_get_channels(png_, info_);
    samples.bytes_per_sample = png_get_bit_depth(png_, info_) / 8;
    const size_t row_bytes = png_get_rowbytes(png_, info_);
    samples.bytes.resize(row_bytes * samples.height);
    std::vector<png_bytep> rows(samples.height);
    for (int y = 0; y < samples.height; ++y) rows[y] = samples.bytes.data() + row_bytes * y;
    const bool done = Guarded(png_, [this, &rows] {
      png_read_image(png_, rows.data());
      png_read_end(png_, nullptr);
    });
    if (!done) return Error();
    return samples;
  }

 private:
  void AskForWholeBytes() {
    const int color_type = png_get_color_type(png_, info_);
    if (color_type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (color_type == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(png_);
    if (png_get_valid(png_, info_, PNG_INFO_tRNS) != 0) png_set_tRNS_to_alpha(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
  }

  absl::Status Error() const {
    return absl::InvalidArgumentError(absl::StrCat("PNG: ", error_.text));
  }

  absl::string_view rest_;
  ErrorText error_;
  png_structp png_;
  png_infop info_;
};

absl::Status CheckSize(const PngReader& reader, const PngLimits& limits, int64_t bytes) {
  const int64_t width = reader.width(), height = reader.height(), pixels = width * height;
  struct Bound {
    absl::string_view name;
    int64_t value, limit;
  };
  for (const auto& [name, value, limit] :
       {Bound{"width", width, limits.max_width}, Bound{"height", height, limits.max_height},
        Bound{"number of pixels", pixels, limits.max_pixels}}) {
    if (value <= limit) continue;
    return absl::ResourceExhaustedError(
        absl::StrCat("PNG: its ", name, " is ", value, "; the limit is ", limit));
  }
  if (pixels * reader.bits_per_pixel() / 8 > kMostInflation * bytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        "PNG: claims ", width, " x ", height, " pixels, more than ", bytes, " bytes can hold"));
  }
  return absl::OkStatus();
}

// A std::string must not throw through libpng, and libpng must not jump out of a catch block.
void AppendBytes(png_structp png, png_bytep data, size_t size) {
  bool appended = true;
  try {
    static_cast<std::string*>(png_get_io_ptr(png))
        ->append(reinterpret_cast<const char*>(data), size);
  } catch (const std::bad_alloc&) {
    appended = false;
  }
  if (!appended) png_error(png, "there is no memory left");
}

void FlushNothing(png_structp) {}

class PngWriter {
 public:
  PngWriter()
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &error_, OnError, OnWarning)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {}
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  absl::StatusOr<std::string> Write(const Image& image, int bits) {
    if (info_ == nullptr) return absl::ResourceExhaustedError("PNG: there is no memory left");
    std::string bytes;
    std::vector<png_byte> row(static_cast<size_t>(image.width) * image.channels * (bits / 8));
    const bool done = Guarded(png_, [this, &image, bits, &bytes, &row] {
      png_set_write_fn(png_, &bytes, AppendBytes, FlushNothing);
      png_set_IHDR(png_, info_, image.width, image.height, bits,
                   image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
                   PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
      png_write_info(png_, info_);
      for (int y = 0; y < image.height; ++y) {
        FillRow(image.at(0, y), bits, &row);
        png_write_row(png_, row.data());
      }
      png_write_end(png_, nullptr);
    });
    if (!done) return absl::InternalError(absl::StrCat("PNG: ", error_.text));
    return bytes;
  }

 private:
  static void FillRow(const float* values, int bits, std::vector<png_byte>* row) {
    const int sample_bytes = bits / 8, max = (1 << bits) - 1;
    for (size_t k = 0; k < row->size() / sample_bytes; ++k) {
      const float value = values[k] > 0 ? (values[k] < 1 ? values[k] : 1) : 0;  // NaN is not > 0
      const int sample = static_cast<int>(max * static_cast<double>(value) + 0.5);
      if (bits == 16) (*row)[2 * k] = static_cast<png_byte>(sample >> 8);
      (*row)[sample_bytes * k + sample_bytes - 1] = static_cast<png_byte>(sample & 255);
    }
  }

  ErrorText error_;
  png_structp png_;
  png_infop info_;
};

}  // namespace

absl::StatusOr<Image> DecodePng(absl::string_view bytes, const PngLimits& limits) {
  PngReader reader(bytes);
  RETURN_IF_ERROR(reader.ReadHeader());
  RETURN_IF_ERROR(CheckSize(reader, limits, static_cast<int64_t>(bytes.size())));
  ASSIGN_OR_RETURN(const PixelSamples samples, reader.ReadPixels());
  return MaskChannel(samples);
}

absl::StatusOr<std::string> EncodePng(const Image& image, int bits) {
  if (image.empty()) return absl::InvalidArgumentError("PNG: the image has no pixels");
  if (image.channels != 1 && image.channels != 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("PNG: the image has ", image.channels, " channels; expected 1 or 3"));
  }
  if (bits != 8 && bits != 16) {
    return absl::InvalidArgumentError(absl::StrCat("PNG: bits is ", bits, "; expected 8 or 16"));
  }
  return PngWriter().Write(image, bits);
}

}  // namespace cagefit
