#include "scenes/image/image_check.h"

#include <fmt/format.h>
#include <jerror.h>
#include <jpeglib.h>

#include <boost/crc.hpp>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "scenes/base/message_text.h"

namespace pickbed::scenes {
namespace {

// ---- PNG ----

constexpr std::string_view kPngHead = "\x89PNG\r\n\x1a\n";

uint32_t BigEndian32(std::string_view bytes) {
  uint32_t number = 0;
  for (int i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}

std::string FaultOfPng(std::string_view bytes) {
  constexpr size_t kFrame = 12;  // bytes of a chunk without its content: size, name, check sum
  if (!bytes.starts_with(kPngHead)) return "the PNG has a damaged head";
  for (std::string_view rest = bytes.substr(kPngHead.size());;) {
    if (rest.size() < kFrame) return "the PNG is cut short";
    const uint32_t size = BigEndian32(rest);
    if (size > rest.size() - kFrame) return "the PNG is cut short";
    const std::string_view checked = rest.substr(4, 4 + size);
    const std::string_view name = checked.substr(0, 4);
    if (BigEndian32(rest.substr(8 + size)) != PngCheckSum(checked)) {
      return fmt::format("the PNG is damaged: the check sum of its chunk '{}' is wrong",
                         OneLine(std::string(name)));
    }
    rest.remove_prefix(kFrame + size);
    if (name != "IEND") continue;
    return rest.empty() ? "" : fmt::format("the PNG has {} bytes after its end", rest.size());
  }
}

// ---- JPEG ----

// The library calls these functions with a pointer to the first member.
struct JpegErrors {
  jpeg_error_mgr manager;
  std::jmp_buf on_error;
  char text[JMSG_LENGTH_MAX];  // the first warning or error; empty = none
};

void KeepText(j_common_ptr codec) {
  auto& errors = *reinterpret_cast<JpegErrors*>(codec->err);
  if (errors.text[0] == 0) codec->err->format_message(codec, errors.text);
}

// The library must not return from an error.
void LeaveOnError(j_common_ptr codec) {
  KeepText(codec);
  std::longjmp(reinterpret_cast<JpegErrors*>(codec->err)->on_error, 1);
}

// Some cameras write a few bytes more before the end mark. Many bytes are left if the codes are
// damaged.
void KeepWarning(j_common_ptr codec, int level) {
  constexpr int kMaxFillBytes = 16, kEndMark = 0xd9;
  const jpeg_error_mgr& error = *codec->err;
  if (level >= 0) return;
  if (error.msg_code == JWRN_EXTRANEOUS_DATA && error.msg_parm.i[0] <= kMaxFillBytes &&
      error.msg_parm.i[1] == kEndMark) {
    return;
  }
  KeepText(codec);
}

// Decodes at an eighth of the size, which reads all of the data. It has no objects with
// destructors, because an error leaves it by longjmp.
void DecodeSmall(const unsigned char* bytes, size_t size, jpeg_decompress_struct& codec,
                 JpegErrors& errors) {
  if (setjmp(errors.on_error) != 0) return;
  jpeg_create_decompress(&codec);
  jpeg_mem_src(&codec, bytes, size);
  jpeg_read_header(&codec, TRUE);
  codec.scale_num = 1;
  codec.scale_denom = 8;
  jpeg_start_decompress(&codec);
  const JDIMENSION width = codec.output_width * static_cast<JDIMENSION>(codec.output_components);
  const JSAMPARRAY row =
      codec.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&codec), JPOOL_IMAGE, width, 1);
  while (codec.output_scanline < codec.output_height) jpeg_read_scanlines(&codec, row, 1);
  jpeg_finish_decompress(&codec);
}

std::string FaultOfJpeg(std::string_view bytes) {
  jpeg_decompress_struct codec{};
  JpegErrors errors{};
  codec.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = LeaveOnError;
  errors.manager.emit_message = KeepWarning;
  DecodeSmall(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), codec, errors);
  jpeg_destroy_decompress(&codec);
  if (errors.text[0] == 0) return "";
  return fmt::format("the JPEG is damaged: {}", OneLine(errors.text));
}

}  // namespace

uint32_t PngCheckSum(std::string_view bytes) {
  boost::crc_32_type sum;
  sum.process_bytes(bytes.data(), bytes.size());
  return sum.checksum();
}

bool IsPng(std::string_view bytes) { return bytes.starts_with(kPngHead.substr(0, 4)); }

bool IsJpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8"); }

std::string FaultOfImage(std::string_view bytes) {
  if (IsPng(bytes)) return FaultOfPng(bytes);
  if (IsJpeg(bytes)) return FaultOfJpeg(bytes);
  return "";
}

}  // namespace pickbed::scenes
